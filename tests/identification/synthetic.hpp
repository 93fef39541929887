// Data whose truth is known, for the tests of the identification.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "identification/feature_library.hpp"

namespace gustlab {

// A number in (−½, ½) that fills the interval evenly as i runs: the fractional part of i √prime.
inline double spread(Eigen::Index i, double prime) {
  const double x = static_cast<double>(i + 1) * std::sqrt(prime);
  return x - std::floor(x) - 0.5;
}

// A quadrotor that rocks about hover: tilts of ±0.2 rad and thrust of 19.4 ± 2 N, all different.
inline std::vector<FeatureInput> rocking_flight(Eigen::Index samples) {
  std::vector<FeatureInput> flight(static_cast<std::size_t>(samples));
  for (Eigen::Index i = 0; i < samples; ++i) {
    FeatureInput& in = flight[static_cast<std::size_t>(i)];
    const double t = 0.01 * static_cast<double>(i);
    in.roll_rad = 0.12 * std::sin(0.7 * t) + 0.1 * spread(i, 2.0);
    in.pitch_rad = 0.1 * std::cos(1.1 * t) + 0.1 * spread(i, 3.0);
    in.yaw_rad = 0.3 * std::sin(0.2 * t);
    in.thrust_N = 19.4 + 1.0 * std::sin(2.3 * t) + 2.0 * spread(i, 5.0);
    in.velocity_W_mps = {std::cos(0.9 * t), std::sin(0.8 * t), 0.3 * std::sin(1.7 * t)};
  }
  return flight;
}

// The Lorenz system's path from (−8, 8, 27), n samples of 2 ms, by Runge–Kutta steps of 0.1 ms.
inline Eigen::MatrixXd lorenz_path(Eigen::Index n) {
  const auto rate = [](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(10.0 * (x[1] - x[0]), x[0] * (28.0 - x[2]) - x[1], x[0] * x[1] - 8.0 / 3.0 * x[2]);
  };
  constexpr int substeps = 20;
  const double h = 0.002 / substeps;
  Eigen::MatrixXd path(n, 3);
  Eigen::Vector3d x(-8.0, 8.0, 27.0);
  for (Eigen::Index i = 0; i < n; ++i) {
    path.row(i) = x;
    for (int k = 0; k < substeps; ++k) {
      const Eigen::Vector3d a = rate(x), b = rate(x + h / 2 * a), c = rate(x + h / 2 * b), d = rate(x + h * c);
      x += h / 6 * (a + 2 * b + 2 * c + d);
    }
  }
  return path;
}

}  // namespace gustlab
