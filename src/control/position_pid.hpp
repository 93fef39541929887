// Position PIDs as each firmware defines them: from where the vehicle is and should be to thrust and attitude.
#pragma once

#include "control/filters.hpp"
#include "control/legacy_mixer.hpp"
#include "control/low_level.hpp"
#include "control/pid.hpp"

namespace gustlab {

// What of the reference's motion is fed forward.
enum class FeedForward { none, velocity, full };

// The Crazyflie's cascade, 100 Hz (firmware 2024, position_controller_pid): P on position, PI on velocity, in the frame of
// the present heading; outputs are angles in degrees and counts of the motor scale, as in the firmware.
class CrazyfliePosition {
 public:
  struct Options {
    double position_scale = 1.0;  // multiply the firmware's gains
    double velocity_scale = 1.0;
    double integral_scale = 1.0;
    double tilt_limit_rad = 20.0 * pi / 180.0;  // PID_VEL_ROLL_MAX
    FeedForward feedforward = FeedForward::none;
  };
  CrazyfliePosition() = default;
  CrazyfliePosition(const VehicleModel& vehicle, const Options& options, double period_s);

  void reset();
  ThrustAttitude update(const Observation& observation, const Reference& reference);

 private:
  Options options_;
  LegacyMixer mixer_;
  double period_s_ = 0.01;
  PidGains position_gains_, velocity_gains_;
  Pid position_, velocity_;
};

// ArduPilot's cascade (AC_PosControl): square-root law on position, PID with filters on velocity, in world axes; the output
// is an acceleration, limited to a tilt. With other gains it is the generic position PID.
class ForcePosition {
 public:
  struct Options {
    double position_xy_p = 1.0, position_z_p = 1.0;                        // 1/s
    double velocity_xy_p = 2.0, velocity_xy_i = 1.0, velocity_xy_d = 0.5;  // 1/s, 1/s², –
    double velocity_z_p = 5.0, velocity_z_i = 2.5;
    double error_cutoff_hz = 5.0, derivative_cutoff_hz = 5.0;
    double integral_limit_mps2 = 10.0;
    double deceleration_xy_mps2 = 2.5, deceleration_z_mps2 = 2.5;
    double velocity_limit_xy_mps = 10.0, velocity_limit_z_mps = 2.5;
    double tilt_limit_rad = 30.0 * pi / 180.0;
    FeedForward feedforward = FeedForward::full;
  };
  ForcePosition() = default;
  ForcePosition(const VehicleModel& vehicle, const Options& options, double period_s);

  void reset();
  ThrustAttitude update(const Observation& observation, const Reference& reference);

 private:
  Options options_;
  double mass_kg_ = 0.0, gravity_mps2_ = 9.81;
  double period_s_ = 0.01;
  Pid velocity_;
  PidGains gains_;
  LowPass1<Vector3> error_, derivative_;
  Vector3 last_error_ = Vector3::Zero();
  bool first_ = true;
};

}  // namespace gustlab
