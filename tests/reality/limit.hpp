// how strong an effect must be before these flights can show it (DIAGNOSIS.md, section 6)
#pragma once

#include "catalogue.hpp"
#include "information.hpp"

namespace reality {

/// What a trial conceals before its strength is known: an effect, its direction in natural sizes (norm one) and the
/// numbers that do not scale (rotor, length, ...).
struct Plan {
  std::string effect;
  std::vector<std::map<std::string, double>> direction;  // one, or one per flight for values per flight
  Values fixed;
};

/// Total values of `plan` on flight n at this strength (in natural sizes).
Values values_at(const Plan& plan, const Nominal& nominal, double strength, std::size_t flight);

/// The fit flights without what the trial conceals, and what is known of them.
struct Scene {
  std::vector<Flight> flight;
  std::vector<Truth> base;
  Columns columns;
  Noise noise;
};

struct Limit {
  double strength = 0;       // in natural sizes
  double tolerance = 0;      // its three parts
  double materiality = 0;
  double five_sigma = 0;
};

/// Detection limit of `plan`; `load_push` holds the cable force per kilogram for a slung load.
Limit detection_limit(const Plan& plan, const Scene& scene,
                      const std::vector<std::vector<Eigen::Matrix<double, 6, 1>>>& load_push);

/// Strength of a saturation whose whole effect weighs `factor` times the limit, and the limit itself; zero if the
/// flights never come near.
std::pair<double, Limit> saturation_strength(const Plan& plan, const Scene& scene, double factor);

/// Gain in chi-square that a model must bring on these flights (the larger of materiality and five sigma).
double threshold(double samples);

}  // namespace reality
