// The Kalman filter that weighs what the simulator missed, and the EM that learns how noisy the flight was.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "diagnosis/linear_model.hpp"

namespace gustlab::diagnosis {

// groups of the disturbance: horizontal force, vertical force, roll/pitch torque, yaw torque
inline constexpr int disturbance_groups = 4;
inline constexpr std::array<int, 6> disturbance_group = {0, 0, 1, 2, 2, 3};
// groups of the measurement noise: position (or velocity), attitude, rate, specific force
inline constexpr int noise_groups = 4;

// longest correlation time of a disturbance: what is slower would take a constant for chance
inline constexpr double slowest_disturbance_s = 1.0;

// correlation time of a calm room's air
inline constexpr double calm_memory_s = 0.2;

// of white acceleration, the time that a calm room's reference floor was measured with: power = 2 white_mean_s × variance of such means
constexpr double white_mean_s(std::size_t group) { return group < 2 ? 0.01 : 0.004; }

// What commands do not foretell of a measured rotor speed: an Ornstein–Uhlenbeck process beside white noise, alike of all rotors.
struct SpeedNoise {
  double variance = 0.0, time_s = 0.1;  // (rad/s)²
  double white = 0.0;                   // variance, (rad/s)²; 0: nothing is known yet
};

// What nothing explains, in each group a slow Ornstein–Uhlenbeck process (air) beside white acceleration (rotors, commands between
// samples), and the noise of the sensors; itself a result ("unexplained disturbance 0.06 m/s², 0.15 s").
struct NoiseModel {
  std::array<double, disturbance_groups> variance{};    // of the slow part, (m/s²)² or (rad/s²)²
  std::array<double, disturbance_groups> time_s{};      // its correlation time
  std::array<double, disturbance_groups> white{};       // power of the white part, (m/s²)² s or (rad/s²)² s
  std::array<double, noise_groups> measurement{};       // variances, SI²
  // Of errors that last (an estimator's, an interpolated pose's, a filtered gyro's): an Ornstein–Uhlenbeck process beside them.
  std::array<double, noise_groups> lasting_variance{}, lasting_time_s{};
  bool errors_last() const { return lasting_time_s[0] > 0.0; }
  SpeedNoise speeds;
  // A simulator is not believed more than this: integrators and build differ, even where the air is still.
  std::array<double, disturbance_groups> least_white{};
  bool possible() const;  // no slower than the slowest disturbance, no less white than the least
  // Both parts, the white one averaged over white_mean_s. Of a force, where errors of the sensors hide what is fast: of a process of
  // a calm room's memory that is as strong at low frequency.
  double rms(std::size_t group) const;
};

// Innovations of y (last column) and of every column of the flight, whitened: rows in the order of arrival.
struct Whitened {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows;
  std::vector<double> time_s;        // of each row
  std::vector<int> channel;          // 0–11
  std::vector<bool> warm;            // false while the filter forgets its prior
  double minus_two_log_likelihood = 0.0;
};

// `extra`: further columns (m pushes per sample), appended before y.
Whitened whiten(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                const std::vector<Pushes>* extra = nullptr);

// Autocorrelation of the warm innovations of y (NaN where there are few): [lag − 1][channel], over all flights.
std::vector<std::array<double, row_count>> lag_correlation(const std::vector<Whitened>& flights, std::size_t lags);

// Sufficient statistics of one flight for EM, and the smoothed disturbance.
struct Smoothed {
  // of the disturbance and of errors that last: Σ E[d²], Σ E[d_k d_{k−1}]
  std::array<double, 6 + row_count> second{}, lagged{}, pairs{}, count{};
  std::array<double, 6> white{};                 // Σ E[w²] / Δt of the white part, over pairs
  std::array<double, noise_groups> residual{}, residual_count{};
  std::vector<Eigen::Matrix<double, 6, 1>> disturbance, disturbance_variance;   // both parts; variance of the slow one
};
Smoothed smooth(const LinearFlight& flight, const NoiseModel& noise);

// One EM update from the statistics of several flights.
NoiseModel update(const NoiseModel& noise, const std::vector<Smoothed>& flights, double sample_s);
// Where EM, which creeps, would come from three models in a row: each logarithm as a geometric series (Aitken).
NoiseModel extrapolated(const NoiseModel& first, const NoiseModel& second, const NoiseModel& third);

}  // namespace gustlab::diagnosis
