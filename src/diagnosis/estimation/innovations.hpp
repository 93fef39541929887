// What the innovation filter gives: whitened innovations, and the statistics that EM learns from.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "diagnosis/model/linear_flight.hpp"

namespace gustlab::diagnosis {

// groups of the disturbance: horizontal force, vertical force, roll/pitch torque, yaw torque
inline constexpr int disturbance_groups = 4;
inline constexpr std::array<int, 6> disturbance_group = {0, 0, 1, 2, 2, 3};
// groups of the measurement noise: position (or velocity), attitude, rate, specific force
inline constexpr int noise_groups = 4;

// Columns beside those of a linearised flight: 6 × size accelerations of a sample, valid until the next call.
struct FurtherColumns {
  Eigen::Index size = 0;
  std::function<const SpatialAccelerations&(std::size_t sample)> at;
};

// Innovations of y (last column) and of every column of the flight, whitened: rows in the order of arrival.
struct Whitened {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows;
  std::vector<double> time_s;  // of each row
  std::vector<int> channel;    // 0–11
  std::vector<bool> warm;      // false while the filter forgets its prior
  double minus_two_log_likelihood = 0.0;
};

// Autocorrelation of the warm innovations of y (NaN where there are few): [lag − 1][channel], over all flights.
std::vector<std::array<double, row_count>> lag_correlation(const std::vector<Whitened>& flights, std::size_t lags);

// Sufficient statistics of one flight for EM, and the smoothed disturbance.
struct Smoothed {
  // of the disturbance and of errors that last: Σ E[d²] over all samples, over the earlier and over the later one of every pair; Σ E[d_k d_{k−1}]
  std::array<double, 6 + row_count> second{}, earlier{}, later{}, lagged{}, pairs{}, count{};
  std::array<double, 6> white{};  // Σ E[w²] / Δt of the white part, over pairs
  std::array<double, noise_groups> residual{}, residual_count{};
  std::vector<Eigen::Matrix<double, 6, 1>> disturbance, disturbance_variance;  // both parts; variance of the slow one
};

}  // namespace gustlab::diagnosis
