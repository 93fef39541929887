// ArduPilot Copter's attitude and rate loops, 400 Hz, and its mixer, with the gains of the Gazebo Iris
// (AC_AttitudeControl_Multi, AC_PID, AP_MotorsMatrix; parameters of ArduPilot 4.x and its Gazebo model).
//
// Left out: the shaping of the attitude target (ATC_INPUT_TC), which only feeds rates forward.
#include "control/attitude.hpp"
#include "control/filters.hpp"
#include "control/low_level.hpp"
#include "control/pid.hpp"
#include "control/rotors.hpp"

namespace gustlab {

namespace {

constexpr double degree = pi / 180.0;

constexpr double angle_p = 4.5;                                     // ATC_ANG_*_P, 1/s
constexpr double tilt_deceleration_radps2 = 0.5 * 1100.0 * degree;  // half of ATC_ACCEL_R_MAX
constexpr double yaw_deceleration_radps2 = 0.5 * 270.0 * degree;    // half of ATC_ACCEL_Y_MAX
// ATC_RAT_*: torque as a share of the motors' range per rad/s
const PidGains rate_gains{{0.135, 0.135, 0.18}, {0.135, 0.135, 0.018}, {0.0036, 0.0036, 0.0}, {3.7, 3.7, 27.8}};
constexpr double target_cutoff_hz = 20.0;      // ATC_RAT_*_FLTT
constexpr double derivative_cutoff_hz = 20.0;  // ATC_RAT_*_FLTD
constexpr double yaw_error_cutoff_hz = 2.5;    // ATC_RAT_YAW_FLTE
constexpr double thrust_expo = 0.65;           // MOT_THST_EXPO

class ArduPilotLoop final : public LowLevelLoop {
 public:
  ArduPilotLoop(const VehicleModel& vehicle, double period_s)
      : period_s_(period_s),
        count_(vehicle.rotor_count),
        max_speed_radps_(vehicle.max_speed_radps),
        full_speed_radps_(PwmMap(vehicle).speed_of_pwm(full_pwm)),
        coefficient_Ns2_(vehicle.rotors[0].thrust_coefficient_Ns2) {
    for (int i = 0; i < count_; ++i) {
      const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
      const Vector3 hub = rotor.position_B_m - vehicle.center_of_mass_B_m;
      share_[static_cast<std::size_t>(i)] =
          0.5 * Vector3(hub.y() > 0.0 ? 1.0 : -1.0, hub.x() > 0.0 ? -1.0 : 1.0, -rotor.direction);
    }
  }

  void reset(const Observation& first) override {
    rate_ = Pid(rate_gains);
    target_ = LowPass1<Vector3>(time_constant_of(target_cutoff_hz), period_s_, Vector3::Zero());
    derivative_ = LowPass1<Vector3>(time_constant_of(derivative_cutoff_hz), period_s_, Vector3::Zero());
    yaw_error_ = LowPass1<double>(time_constant_of(yaw_error_cutoff_hz), period_s_, 0.0);
    last_error_ = -first.body_rate_B_radps;
    command({0.0, first.attitude_WB});
  }

  void command(const ThrustAttitude& wanted) override {
    wanted_WB_ = wanted.attitude_WB;
    // thrust in N → the share of the range that the thrust curve turns into the right speed
    const double speed = std::sqrt(std::max(wanted.thrust_N / count_, 0.0) / coefficient_Ns2_);
    const double throttle = limited(speed, max_speed_radps_) / full_speed_radps_;
    thrust_ = (1.0 - thrust_expo) * throttle + thrust_expo * throttle * throttle;
  }

  RotorCommand update(const Observation& observation) override {
    // attitude error → rate, thrust direction and heading apart
    const Vector3 error = attitude_error_B_rad(observation.attitude_WB, wanted_WB_, 1.0);
    const Vector3 wanted_rate(square_root_law(error.x(), angle_p, tilt_deceleration_radps2),
                              square_root_law(error.y(), angle_p, tilt_deceleration_radps2),
                              square_root_law(error.z(), angle_p, yaw_deceleration_radps2));

    // rate error → share of the motors' range
    Vector3 rate_error = target_.update(wanted_rate) - observation.body_rate_B_radps;
    rate_error.z() = yaw_error_.update(rate_error.z());
    const Vector3 change = derivative_.update((rate_error - last_error_) / period_s_);
    last_error_ = rate_error;
    const Vector3 torque = limited(rate_.update(rate_error, change, period_s_), Vector3::Ones());
    return mixed(torque);
  }

 private:
  // roll and pitch first, thrust makes room for them, yaw takes the rest
  RotorCommand mixed(const Vector3& torque) const {
    RotorArray tilt{};
    double least = 0.0, most = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
      tilt[i] = share_[i].head<2>().dot(torque.head<2>());
      least = std::min(tilt[i], least);
      most = std::max(tilt[i], most);
    }
    const double scale = most - least > 1.0 ? 1.0 / (most - least) : 1.0;
    const double thrust = std::clamp(thrust_, -scale * least, std::max(1.0 - scale * most, -scale * least));
    double room = 1.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
      const double turn = share_[i].z() * torque.z();
      const double now = thrust + scale * tilt[i];
      room = std::min(room, std::max(turn > 0.0 ? 1.0 - now : now, 0.0) / std::max(std::abs(turn), 1e-9));
    }
    RotorCommand command;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
      const double share = std::clamp(thrust + scale * tilt[i] + room * share_[i].z() * torque.z(), 0.0, 1.0);
      const double throttle =
          (thrust_expo - 1.0 + std::sqrt((1.0 - thrust_expo) * (1.0 - thrust_expo) + 4.0 * thrust_expo * share)) /
          (2.0 * thrust_expo);
      command.speed_radps[i] = limited(throttle * full_speed_radps_, max_speed_radps_);
    }
    return command;
  }

  double period_s_;
  int count_;
  double max_speed_radps_;
  double full_speed_radps_;  // at full throttle, which the plant may not reach
  double coefficient_Ns2_;
  std::array<Vector3, max_rotors> share_;
  Pid rate_;
  LowPass1<Vector3> target_, derivative_;
  LowPass1<double> yaw_error_;
  Vector3 last_error_ = Vector3::Zero();
  Quaternion wanted_WB_ = Quaternion::Identity();
  double thrust_ = 0.0;
};

}  // namespace

std::unique_ptr<LowLevelLoop> make_ardupilot_loop(const VehicleModel& vehicle, double period_s) {
  return std::make_unique<ArduPilotLoop>(vehicle, period_s);
}

}  // namespace gustlab
