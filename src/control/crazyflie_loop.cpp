// The Crazyflie's attitude and rate loops, 500 Hz, over its legacy mixer (firmware 2024, attitude_pid_controller). Units are the firmware's: degrees, and counts of a 16 bit motor scale.
#include <cmath>

#include "control/attitude.hpp"
#include "control/filters.hpp"
#include "control/legacy_mixer.hpp"
#include "control/low_level.hpp"
#include "control/pid.hpp"

namespace gustlab {

namespace {

constexpr double degree = pi / 180.0;

// platform_defaults_cf2.h; roll, pitch, yaw
const PidGains attitude_gains{{6.0, 6.0, 6.0}, {3.0, 3.0, 1.0}, {0.0, 0.0, 0.35}, {20.0, 20.0, 360.0}};
const PidGains rate_gains{{250.0, 250.0, 120.0}, {500.0, 500.0, 16.7}, {2.5, 2.5, 0.0}, {33.3, 33.3, 166.7}};
constexpr double derivative_cutoff_hz = 20.0;
constexpr double torque_limit = 32767.0;  // int16

class CrazyflieLoop final : public LowLevelLoop {
 public:
  CrazyflieLoop(const VehicleModel& vehicle, double period_s) : period_s_(period_s), mixer_(vehicle) {}

  void reset(const Observation& first) override {
    attitude_ = Pid(attitude_gains);
    rate_ = Pid(rate_gains);
    last_angle_deg_ = degrees(first.attitude_WB);
    last_rate_degps_ = first.body_rate_B_radps / degree;
    derivative_ = LowPass2<Vector3>(derivative_cutoff_hz, period_s_, Vector3::Zero());
    command({});
  }

  void command(const ThrustAttitude& wanted) override {
    // roll and pitch of the wanted thrust direction, seen from the heading at this moment
    const double yaw_rad = last_angle_deg_.z() * degree, c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    const Vector3 z = wanted.attitude_WB * Vector3::UnitZ();
    wanted_deg_ = Vector3(std::asin(limited(s * z.x() - c * z.y(), 1.0)), std::atan2(c * z.x() + s * z.y(), z.z()),
                          yaw_of(wanted.attitude_WB)) /
                  degree;
    thrust_pwm_ = std::clamp(mixer_.pwm_of_total_thrust(wanted.thrust_N), 0.0, full_pwm);
  }

  RotorCommand update(const Observation& observation) override {
    const Three angle_deg = degrees(observation.attitude_WB);
    const Three rate_degps = Three(observation.body_rate_B_radps) / degree;

    // attitude error → rate, in Euler angles; derivative of the measured angle, not of the error
    Three error_deg = wanted_deg_ - angle_deg;
    error_deg.z = wrapped_deg(error_deg.z);
    Three angle_change_deg = last_angle_deg_ - angle_deg;
    angle_change_deg.z = wrapped_deg(angle_change_deg.z);
    last_angle_deg_ = angle_deg;
    const Three wanted_rate_degps = attitude_.update(error_deg, angle_change_deg / period_s_, period_s_);

    // rate error → torque in counts
    const Three rate_change = (last_rate_degps_ - rate_degps) / period_s_;
    last_rate_degps_ = rate_degps;
    const Vector3 torque =
        limited(rate_.update(wanted_rate_degps - rate_degps, derivative_.update(rate_change), period_s_),
                Vector3::Constant(torque_limit));

    return mixer_.speeds(thrust_pwm_, torque);
  }

 private:
  // std::remainder is slow, and seldom needed
  static double wrapped_deg(double angle_deg) {
    return std::abs(angle_deg) < 180.0 ? angle_deg : std::remainder(angle_deg, 360.0);
  }
  static Vector3 degrees(const Quaternion& attitude_WB) {
    const EulerAngles angles = euler_angles(attitude_WB);
    return Vector3(angles.roll_rad, angles.pitch_rad, angles.yaw_rad) / degree;
  }

  double period_s_;
  LegacyMixer mixer_;
  Pid attitude_, rate_;
  LowPass2<Vector3> derivative_;
  Vector3 last_angle_deg_ = Vector3::Zero(), last_rate_degps_ = Vector3::Zero();
  Vector3 wanted_deg_ = Vector3::Zero();
  double thrust_pwm_ = 0.0;
};

}  // namespace

std::unique_ptr<LowLevelLoop> make_crazyflie_loop(const VehicleModel& vehicle, double period_s) {
  return std::make_unique<CrazyflieLoop>(vehicle, period_s);
}

}  // namespace gustlab
