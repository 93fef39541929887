// One model along one recording: rotors driven by the recorded inputs, the body let go at a sample.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/recording/recorded_motion.hpp"
#include "plant/plant.hpp"

namespace gustlab::diagnosis {

// How rollouts are flown along a recording.
struct ReplayOptions {
  std::vector<double> horizon_s{0.1, 0.5, 1.0};  // rising
  int stride = 0;                                // samples between window starts; 0: windows do not overlap
  int jobs = 1;
  double max_step_s = 1e-3;      // MuJoCo's Euler moves a body by ½ a dt² too much per step
  bool with_noise = true;        // also what measurement noise alone would give
  bool fit_per_flight = true;    // the model's values per flight, from what came before each window
  double command_delay_s = 0.0;  // by which the log's inputs come too early
  // What the caller knows better of the state that a window starts from: (row, state) → state. After sensor effects were
  // taken out; empty: as it is.
  std::function<void(std::size_t, VehicleState&)> correct_start;
};

// What every rollout on one recording shares.
struct Recording {
  FlightLog log;  // whose rows hold the whole motion
  RecordedMotion motion;
  VehicleModel vehicle;  // with the flight's surroundings, and nothing that touches the ground
  CommandRecord inputs;
  bool speed_is_measured = false;
  bool collective_only = false;   // the attitude is taken as recorded
  std::vector<double> voltage_V;  // per row, the last that was measured; empty: not known
  double step_s = 0.001;          // of the plant; divides the sample interval

  Recording(const FlightLog& log, const VehicleModel& vehicle, const ReplayOptions& options);
};

class Rollout {
 public:
  // `effects`: all that act; those that are pure chance are left out.
  Rollout(const Recording& recording, const std::vector<EffectSpec>& effects);

  // Rotor speeds at every row, from running the command's way over the whole recording.
  std::vector<RotorArray> rotor_speeds();
  // Seconds by which the pose is late in this model.
  double pose_delay_s() const { return pose_delay_s_; }
  // The state behind a recorded sample, sensor effects taken out; its time is that of the (late) pose.
  VehicleState start(std::size_t row) const;
  // Lets the body go; rotor_speeds as above.
  void begin(const VehicleState& start, const std::vector<RotorArray>& rotor_speeds);
  // What the sensors say at a later time; false when the state left the numbers.
  bool run_to(double time_s, Measured& seen);

 private:
  RotorCommand command(double from_s) const;
  void restart_rotors(const RotorArray& speed_radps);
  bool advance();

  const Recording& recording_;
  Plant plant_;
  double pose_delay_s_ = 0.0;
  double begin_s_ = 0.0;
  Quaternion beside_recorded_ = Quaternion::Identity();  // attitude at the start, in the axes of the recorded one
  Measured before_, now_;
  std::int64_t steps_ = 0;
};

}  // namespace gustlab::diagnosis
