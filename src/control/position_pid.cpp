#include "control/position_pid.hpp"

#include "control/attitude.hpp"

namespace gustlab {

namespace {

constexpr double degree = pi / 180.0;

// platform_defaults_cf2.h
constexpr double velocity_limit_mps = 1.0 * 1.1;  // PID_POS_VEL_*_MAX with its overhead
constexpr double tilt_overhead = 1.1;
constexpr double thrust_base_pwm = 36000.0, thrust_least_pwm = 20000.0;
constexpr double pwm_per_output = 1000.0;
constexpr double vertical_output_limit = full_pwm / 2.0 / pwm_per_output;
constexpr double integral_limit = 5000.0;  // DEFAULT_PID_INTEGRATION_LIMIT

}  // namespace

CrazyfliePosition::CrazyfliePosition(const VehicleModel& vehicle, const Options& options, double period_s)
    : options_(options), mixer_(vehicle), period_s_(period_s) {
  position_gains_.p = options.position_scale * Vector3(2.0, 2.0, 2.0);
  position_gains_.i = options.integral_scale * Vector3(0.0, 0.0, 0.5);
  velocity_gains_.p = options.velocity_scale * Vector3(25.0, 25.0, 25.0);
  velocity_gains_.i = options.integral_scale * Vector3(1.0, 1.0, 15.0);
  position_gains_.integral_limit = velocity_gains_.integral_limit = Vector3::Constant(integral_limit);
  reset();
}

void CrazyfliePosition::reset() {
  position_ = Pid(position_gains_);
  velocity_ = Pid(velocity_gains_);
}

ThrustAttitude CrazyfliePosition::update(const Observation& observation, const Reference& reference) {
  const double yaw_rad = yaw_of(observation.attitude_WB);
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const auto to_heading = [&](const Vector3& v) {
    return Vector3(c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z());
  };

  // position → velocity
  Vector3 wanted_velocity = limited(
      position_.update(to_heading(reference.position_W_m - observation.position_W_m), Vector3::Zero(), period_s_),
      Vector3::Constant(velocity_limit_mps));
  if (options_.feedforward != FeedForward::none) wanted_velocity += to_heading(reference.velocity_W_mps);

  // velocity → pitch, roll in degrees, thrust in counts above the base
  const Vector3 output =
      velocity_.update(wanted_velocity - to_heading(observation.velocity_W_mps), Vector3::Zero(), period_s_);
  const double tilt_deg = options_.tilt_limit_rad / degree;
  double pitch_rad = limited(limited(output.x(), tilt_overhead * tilt_deg), tilt_deg) * degree;
  double roll_rad = -limited(limited(output.y(), tilt_overhead * tilt_deg), tilt_deg) * degree;
  if (options_.feedforward == FeedForward::full) {
    const Vector3 acceleration = to_heading(reference.acceleration_W_mps2);
    pitch_rad = limited(pitch_rad + acceleration.x() / 9.81, options_.tilt_limit_rad);
    roll_rad = limited(roll_rad - acceleration.y() / 9.81, options_.tilt_limit_rad);
  }
  const double pwm = std::clamp(pwm_per_output * limited(output.z(), vertical_output_limit) + thrust_base_pwm,
                                thrust_least_pwm, full_pwm);
  // the third column of Rz(yaw) Ry(pitch) Rx(roll)
  const double sr = std::sin(roll_rad), cr = std::cos(roll_rad), sp = std::sin(pitch_rad), cp = std::cos(pitch_rad);
  const Vector3 thrust_axis(c * sp * cr + s * sr, s * sp * cr - c * sr, cp * cr);
  return {mixer_.total_thrust_of_pwm(pwm), attitude_along(thrust_axis, reference.yaw_rad)};
}

ForcePosition::ForcePosition(const VehicleModel& vehicle, const Options& options, double period_s)
    : options_(options), mass_kg_(vehicle.mass_kg), gravity_mps2_(vehicle.gravity_mps2), period_s_(period_s) {
  const auto limit = [&](double gain) { return gain > 0.0 ? options.integral_limit_mps2 / gain : 0.0; };
  gains_.p = {options.velocity_xy_p, options.velocity_xy_p, options.velocity_z_p};
  gains_.i = {options.velocity_xy_i, options.velocity_xy_i, options.velocity_z_i};
  gains_.d = {options.velocity_xy_d, options.velocity_xy_d, 0.0};
  gains_.integral_limit = {limit(options.velocity_xy_i), limit(options.velocity_xy_i), limit(options.velocity_z_i)};
  reset();
}

void ForcePosition::reset() {
  velocity_ = Pid(gains_);
  error_ = LowPass1<Vector3>(time_constant_of(options_.error_cutoff_hz), period_s_, Vector3::Zero());
  derivative_ = LowPass1<Vector3>(time_constant_of(options_.derivative_cutoff_hz), period_s_, Vector3::Zero());
  last_error_.setZero();
  first_ = true;
}

ThrustAttitude ForcePosition::update(const Observation& observation, const Reference& reference) {
  // position → velocity, the horizontal part along the error
  const Vector3 error = reference.position_W_m - observation.position_W_m;
  const double distance = error.head<2>().norm();
  const double p = options_.position_xy_p;
  Vector3 wanted_velocity = p * error;
  if (distance > 1e-9) {
    const double speed =
        limited(square_root_law(distance, p, options_.deceleration_xy_mps2), options_.velocity_limit_xy_mps);
    wanted_velocity.head<2>() = error.head<2>() * (speed / distance);
  }
  wanted_velocity.z() = limited(square_root_law(error.z(), options_.position_z_p, options_.deceleration_z_mps2),
                                options_.velocity_limit_z_mps);
  if (options_.feedforward != FeedForward::none) wanted_velocity += reference.velocity_W_mps;

  // velocity → acceleration; the error and its derivative filtered
  const Vector3 before = velocity_.integral();
  const Vector3 velocity_error = error_.update(wanted_velocity - observation.velocity_W_mps);
  if (first_) last_error_ = velocity_error;
  first_ = false;
  const Vector3 change = derivative_.update((velocity_error - last_error_) / period_s_);
  last_error_ = velocity_error;
  Vector3 acceleration = velocity_.update(velocity_error, change, period_s_);
  if (options_.feedforward == FeedForward::full) acceleration += reference.acceleration_W_mps2;

  // acceleration → force within the tilt limit; there the horizontal integral stands still
  const Vector3 wanted_force = mass_kg_ * (acceleration + gravity_mps2_ * Vector3::UnitZ());
  const Vector3 force = tilt_limited(wanted_force, options_.tilt_limit_rad, 0.1 * mass_kg_ * gravity_mps2_);
  if (force.head<2>() != wanted_force.head<2>()) velocity_.hold({before.x(), before.y(), velocity_.integral().z()});

  // as much thrust as the present tilt asks for, up to 60 degrees (angle boost)
  const double cos_tilt = 1.0 - 2.0 * (observation.attitude_WB.x() * observation.attitude_WB.x() +
                                       observation.attitude_WB.y() * observation.attitude_WB.y());
  const double boost = std::clamp(2.0 * cos_tilt, 0.0, 1.0) / std::clamp(cos_tilt, 0.5, 1.0);
  return {force.z() * boost, attitude_along(force, reference.yaw_rad)};
}

}  // namespace gustlab
