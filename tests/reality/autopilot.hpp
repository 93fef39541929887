// a cascade that flies on what the sensors say
#pragma once

#include "paths.hpp"

namespace reality {

/// What the sensors deliver at one sample.
struct Reading {
  Vec3 position_W_m, velocity_W_mps, gyro_B_radps, specific_B_mps2;
  Quat attitude;
};

/// Position PID over a geometric attitude loop, 100 Hz, on noisy readings one sample old. Its gains follow the
/// actuators' true slowness, as a pilot would retune until the vehicle flies.
class Autopilot {
 public:
  Autopilot(const Truth& truth, const Path& path);
  /// rotor speed commands [rad/s] for time t from the reading of the sample before
  PerRotor command(double time_s, const Reading& reading);

 private:
  void estimate(const Reading& reading);
  Mat3 wanted_attitude(const Vec3& push_W_mps2, double yaw_rad) const;
  PerRotor mix(double thrust_N, const Vec3& torque_Nm) const;

  const Nominal& nominal_;
  const Path& path_;
  double rate_gain_, yaw_gain_, slow_gain_, climb_gain_;
  Eigen::Matrix4d mixer_;
  bool started_ = false;
  Vec3 position_W_m_, velocity_W_mps_;
  Quat attitude_;
  Vec3 pushed_W_mps2_ = Vec3::Zero();
  Vec3 position_sum_ = Vec3::Zero(), attitude_sum_ = Vec3::Zero();
};

}  // namespace reality
