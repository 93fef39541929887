// how strong an effect must be before these flights can show it (DIAGNOSIS.md, section 6)
#pragma once

#include "information.hpp"
#include "plan.hpp"

namespace reality {

using Pushes = std::vector<std::vector<Eigen::Matrix<double, 6, 1>>>;  // [flight][sample]: force W, torque B

/// The fit flights without what the trial conceals, and what is known of them.
struct Scene {
  std::vector<Flight> flight;
  std::vector<Truth> base;
  Columns columns;
  Noise noise;
};

/// A detection limit in natural sizes, and its three parts; zero where a part does not apply.
struct Limit {
  double strength = 0;
  double tolerance = 0;
  double materiality = 0;
  double five_sigma = 0;
};

/// Scalar measurements of the scene: the degrees of freedom of DIAGNOSIS.md.
double measurements(const Scene& scene);

/// Gain in chi-square that an effect must bring on these flights: materiality or five sigma, whichever is larger.
double threshold(const Scene& scene);

/// Detection limit of an effect whose footprint grows with its strength; `load_push` is the cable force per kilogram
/// for a slung load, empty otherwise. `total_gain`: what all concealed effects together gain, for materiality's share.
Limit detection_limit(const Plan& plan, const Scene& scene, const Pushes& load_push);

/// A saturation bites only beyond some strength: the strength at which it weighs `factor` times the limit.
struct Bite {
  double strength = 0;
  double factor = 0;  // as reached
  Limit limit;
};
Bite saturation_bite(const Plan& plan, const Scene& scene, double factor);

/// Square root of (gain / threshold) of physics outside the catalogue: given as truths that have it or as pushes.
double visibility(const std::vector<Truth>& with, const Pushes& pushes, const Scene& scene);

}  // namespace reality
