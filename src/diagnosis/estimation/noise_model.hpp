// How noisy a flight is: its disturbance and its sensors, and the EM step that learns them.
#pragma once

#include <array>
#include <vector>

#include "diagnosis/estimation/innovations.hpp"

namespace gustlab::diagnosis {

// longest correlation time of a disturbance: what is slower would take a constant for chance
inline constexpr double slowest_disturbance_s = 1.0;

// correlation time of a calm room's air
inline constexpr double calm_memory_s = 0.2;

// of white acceleration, the time that a calm room's reference floor was measured with: power = 2 white_mean_s × variance of such means
constexpr double white_mean_s(std::size_t group) { return group < 2 ? 0.01 : 0.004; }

// What commands do not predict of a measured rotor speed: an Ornstein–Uhlenbeck process beside white noise, alike of all rotors.
struct SpeedNoise {
  double variance = 0.0, time_s = 0.1;  // (rad/s)²
  double white = 0.0;                   // variance, (rad/s)²; 0: nothing is known yet
};

// What nothing explains, in each group a slow Ornstein–Uhlenbeck process (air) beside white acceleration (rotors, commands between
// samples), and the noise of the sensors; itself a result ("unexplained disturbance 0.06 m/s², 0.15 s").
struct NoiseModel {
  std::array<double, disturbance_groups> variance{};  // of the slow part, (m/s²)² or (rad/s²)²
  std::array<double, disturbance_groups> time_s{};    // its correlation time
  std::array<double, disturbance_groups> white{};     // power of the white part, (m/s²)² s or (rad/s²)² s
  std::array<double, noise_groups> measurement{};     // variances, SI²
  // Of errors that last (an estimator's, an interpolated pose's, a filtered gyro's): an Ornstein–Uhlenbeck process beside them.
  std::array<double, noise_groups> lasting_variance{}, lasting_time_s{};
  bool errors_last() const { return lasting_time_s[0] > 0.0; }
  SpeedNoise speeds;
  // Of what every flight turns more by than the last, from its first sample to its last (a re-seated battery): variance of each axis, (rad/s²)²
  std::array<double, 3> torque_trim{};
  double mean_torque = 0.0;  // variance of mean angular accelerations (mean_torques.hpp), (rad/s²)²; 0: not known yet
  std::array<double, 2> sensor_windows{};  // variances (sensor_windows.hpp), rad² and (m/s)²; 0: not known yet
  // A simulator is not believed more than this: integrators and build differ, even where the air is still.
  std::array<double, disturbance_groups> least_white{};
  bool possible() const;  // no slower than the slowest disturbance, no less white than the least
  // Both parts, the white one averaged over white_mean_s. Of a force, where errors of the sensors hide what is fast: of a process of
  // a calm room's memory that is as strong at low frequency.
  double rms(std::size_t group) const;
};

// One EM update from the statistics of several flights.
NoiseModel update(const NoiseModel& noise, const std::vector<Smoothed>& flights, double sample_s);
// The largest change between two models: of the logarithm of a variance, a power or a time.
double largest_change(const NoiseModel& before, const NoiseModel& after);
// Where EM, which creeps, would come from three models in a row: each logarithm as a geometric series (Aitken).
NoiseModel extrapolated(const NoiseModel& first, const NoiseModel& second, const NoiseModel& third);

}  // namespace gustlab::diagnosis
