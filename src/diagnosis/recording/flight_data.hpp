// A recording made ready for the filter: samples with what each of them measured, commands as rotor speeds, and a
// smoothed trajectory to linearise about.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gustlab/effect.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// What a sample measured, as bits.
enum Channel : unsigned { has_position = 1, has_velocity = 2, has_attitude = 4, has_rate = 8, has_force = 16 };

struct Sample {
  double time_s = 0.0;
  unsigned channels = 0;
  bool starts_segment = false;  // first sample, or first after a gap
  bool saturated = false;       // a command at its limit in the interval before
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  Quaternion attitude_WB = Quaternion::Identity();
  Vector3 body_rate_B_radps = Vector3::Zero();
  Vector3 specific_force_B_mps2 = Vector3::Zero();
  double voltage_V = 0.0;
};

// Smoothed motion of the body's origin; its noise does not bias the result, the filter's state is the deviation from it.
struct Motion {
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  Vector3 acceleration_W_mps2 = Vector3::Zero();
  Quaternion attitude_WB = Quaternion::Identity();
  Vector3 body_rate_B_radps = Vector3::Zero();
  Vector3 angular_acceleration_B_radps2 = Vector3::Zero();
};

// Commands as a function of time: rotor speeds, held or interpolated, with exact means over intervals.
class CommandRecord final {
 public:
  CommandRecord() = default;
  // rows: one RotorArray per time; linear: interpolated, otherwise held from its time stamp on
  CommandRecord(std::vector<double> time_s, std::vector<RotorArray> speed_radps, bool linear);
  RotorArray mean(double from_s, double to_s) const;
  // The same record, later.
  void delay(double by_s);
  // The same record as a filter would leave it whose kernel has this variance; negative: as it was before such a filter.
  void smooth(double variance_s2);
  bool empty() const { return time_s_.empty(); }
  // Rows as they were logged.
  const std::vector<double>& time_s() const { return time_s_; }
  const std::vector<RotorArray>& speed_radps() const { return value_; }

 private:
  std::size_t row_at(double time_s) const;
  RotorArray integral(double time_s) const;
  RotorArray plain_mean(double from_s, double to_s) const;
  std::vector<double> time_s_;
  std::vector<RotorArray> value_, integral_;
  bool linear_ = false;
  double smoothed_s2_ = 0.0;
};

// Standard deviation of white noise on a series, from its third differences (robust): median|Δ³y| / (0.6745 √20).
double third_difference_noise(const std::vector<double>& values);

// What was not predicted of the rotors' acceleration, and its memory: each roll, pitch, yaw [rad/s²], along the body's z [m/s²]; where
// commands are slower than the motion also roll and pitch of the body's rates [rad/s] and of the rotors' acceleration [rad/s²].
using CommandInnovation = Eigen::Matrix<double, 12, 1>;

// Gyro and accelerometer behind the pose, or the pose ahead of all else, see sensor_latency.hpp.
struct SensorLatency {
  double rate_s = 0.0, force_s = 0.0, pose_ahead_s = 0.0;
};

// Rotor speeds over one sample interval, in substeps, and at its start.
struct RotorHistory {
  int substeps = 1;
  std::vector<RotorArray> mean, acceleration;  // substeps per sample interval
  std::vector<RotorArray> at_sample;
};

// What is taken out of the samples before they are smoothed.
struct SensorCorrection {
  Vector3 attitude_offset_B_rad = Vector3::Zero();
  double pose_delay_s = 0.0;
  Vector3 rate_bias_B_radps = Vector3::Zero();
  double rate_scale = 0.0;
  bool operator==(const SensorCorrection&) const = default;
};

// Smoothed readings of a gyroscope, nothing taken out, and what the segment of a sample has enough of to be smoothed.
struct GyroFit {
  Vector3 rate_B_radps = Vector3::Zero(), acceleration_B_radps2 = Vector3::Zero();
  bool known = false, attitude_known = false;
};

struct FlightData {
  std::string file;
  std::string label;     // file name without folder
  VehicleModel vehicle;  // with the flight's environment
  std::vector<Sample> samples;
  std::vector<Motion> motion;  // per sample, with `corrected` taken out
  std::vector<GyroFit> gyro;   // per sample
  SensorCorrection corrected;
  CommandRecord commands;        // mapped to rotor speed
  CommandRecord measured_speed;  // rotor* columns, when there
  // The same where it is known how they go from one row to the next: what drives the body. Empty: it is not.
  CommandRecord jumping_speed;
  std::vector<RotorArray> measured_at_sample;  // the same at the samples; empty: not compared with commands
  RotorHistory estimated;        // of measured speeds and commands together, when that was made: see rotor_speeds.hpp
  bool collective_only = false;  // torques unknown, or not to be judged
  bool has_voltage = false;
  bool inertial_unused = false;  // an accelerometer was recorded, and no attitude to compare it with the path
  SensorLatency late;
  bool loop_goes_on = false;               // between the commands that were logged
  bool hold_known = false;                 // interpolated commands were resampled, or sent faster than the log
  std::vector<Vector3> load_force_W_mps2;  // force of a slung load per kg of it, per sample; empty: none is suspected
  // what a lower speed limit changes, per sample: linear acceleration in W, angular in B; empty: none is suspected
  std::vector<Eigen::Matrix<double, 6, 1>> limit_change;
  std::vector<RotorArray>
      limit_speed_change;  // the same of the speeds that commands predict, where others are measured; rad/s
  std::vector<CommandInnovation> command_innovation;  // see command_innovation.hpp, per sample; empty: not known
  double sample_s = 0.01;                             // median interval
  int substeps = 4;                // per sample interval, on the instants at which commands were logged
  bool as_recorded = false;        // the recorded states are the motion
  bool commands_filtered = false;  // as all else, or not
  bool read_slower = false;        // than it was logged: neighbouring innovations are then never quite white
  double start_s = 0.0;
  // the sensors as they were logged, where the filter leaves inertial data out or all was filtered once more; no commands, no motion
  std::shared_ptr<const FlightData> sensors;
  // with the command of each rotor, where the total alone is known from sample to sample: means of torques over a while
  std::shared_ptr<const FlightData> each_rotor;
  // what is known of the rotors: their measured speeds, or else their commands
  const CommandRecord& rotor_record() const { return measured_speed.empty() ? commands : measured_speed; }
  // Commands and speeds as if they were logged so much later.
  void delay_inputs(double by_s) {
    for (CommandRecord* record : {&commands, &measured_speed, &jumping_speed}) record->delay(by_s);
  }
  // from the first sample to the last
  double duration_s() const { return samples.empty() ? 0.0 : samples.back().time_s - samples.front().time_s; }
  // the same, of a gap no more than longest_walk_s
  double flown_s() const;
};

bool makes_rotors_late(const EffectRow& row);
// Whether rotors follow their commands late, as the vehicle file says.
bool rotors_are_late(const VehicleModel& vehicle);

// how long a motor remembers how fast it turned: some time constants of a slow one
inline constexpr double spin_up_s = 0.15;

struct ReadingOptions {
  std::optional<bool> linear_hold;  // overrides the log when it does not say
  double max_rate_hz = 255.0;       // faster logs are read more slowly
  double coarse_rate_hz = 0.0;      // and those of `least_coarse_hz` and more at it; 0: not
  double least_coarse_hz = 325.0;   // by what the log holds
  double substep_s = 0.0025;        // at most
  // Logs that were low-pass filtered, each column differently, are filtered once more and all alike (Gaussian of this
  // standard deviation, s; commands too), and then sampled: what is linear between them stays as it was. 0: not.
  double common_filter_s = 0.0;
  // The recorded states are the motion: nothing is smoothed over more than a few samples, a recorded velocity counts.
  bool as_recorded = false;
  bool forces_only = false;  // torques are not judged, and with a pose inertial data are not used
  // Of the commands of several rotors their total alone is taken, and `each_rotor` beside it.
  bool total_thrust = false;
  SensorLatency late = {};
};

// The flight without what motors do that still remember how fast they turned before the first command, or before one that comes after a gap.
FlightData without_spin_up(FlightData flight, double spin_up = spin_up_s);

// Rows (last with a value, next with one) between which a column has none for more than 0.1 s and five of its intervals.
std::vector<std::pair<std::size_t, std::size_t>> pose_gaps(const std::vector<double>& time_s,
                                                           const std::vector<double>& values);
// Throws DataError when the actuator input cannot be mapped by the vehicle.
FlightData prepare_flight(const FlightLog& log, const VehicleModel& vehicle, const ReadingOptions& options);
// Smooths pose and rate again, with sensor effects taken out of the samples first. A gyroscope's bias and scale are taken out of what was
// smoothed, which is the same.
void smooth_motion(FlightData& flight, const SensorCorrection& correction);
// Weight of a sample in a local fit, by its distance in half windows (Cleveland, J. Am. Stat. Assoc. 74, 1979).
inline double tricube(double distance) {
  const double a = std::abs(distance), left = 1.0 - a * a * a;
  return a < 1.0 ? left * left * left : 0.0;
}
// Half the window over which body rates are smoothed, s.
double rate_half_window_s(const FlightData& flight);

}  // namespace gustlab::diagnosis
