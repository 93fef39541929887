#include "control/indi.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "control/attitude.hpp"
#include "control/pid.hpp"
#include "util/three.hpp"

namespace gustlab {

namespace {

// Crazyflie firmware, position_controller_indi.h: angular acceleration per count
const Vector3 firmware_g1{0.0066146, 0.0052125, 0.001497};
constexpr double firmware_g2 = 4.3475e-5;
constexpr double firmware_actuator_lag_s = 0.0625;
constexpr double firmware_torque_limit = 32000.0;
constexpr double firmware_k_thrust = 0.00024730;  // m/s² per count
constexpr double firmware_most_thrust = 60000.0;

// pinv([a b c]) y. On its side, a vehicle's thrust is not turned by pitch, or by roll: there it is left as it is.
// The inverse is in the order of Matrix3::computeInverseWithCheck.
Three times_pseudo_inverse(const Three& a, const Three& b, const Three& c, const Three& y) {
  constexpr double least_share = 1e-3;  // a column of what the three span
  const Three across = cross(b, c);
  const double determinant = dot(across, a), most = length(a);
  if (std::abs(determinant) > least_share * most * most) {
    const double inverse = 1.0 / determinant;
    const Three x = inverse * across, other = inverse * cross(c, a), last = inverse * cross(a, b);
    return {dot(x, y), dot(other, y), last.x * y.x + (last.y * y.y + last.z * y.z)};
  }
  Matrix3 G;
  G << Vector3(a), Vector3(b), Vector3(c);
  Eigen::CompleteOrthogonalDecomposition<Matrix3> decomposition;
  decomposition.setThreshold(least_share);
  return Vector3(decomposition.compute(G).solve(Vector3(y)));
}

double follows(double lag_s, double period_s) { return lag_s > 0.0 ? 1.0 - std::exp(-period_s / lag_s) : 1.0; }

}  // namespace

IndiOptions scaled(IndiOptions options, const VehicleModel& vehicle, LowLevel kind, double period_s) {
  if (kind == LowLevel::crazyflie) return options;
  const double factor = std::min(1.0, bandwidths_of(vehicle, period_s).rate / options.rate_gain);
  for (double* gain : {&options.attitude_gain, &options.rate_gain, &options.position_gain, &options.velocity_gain})
    *gain *= factor;
  return options;
}

IndiAttitude::IndiAttitude(const VehicleModel& vehicle, LowLevel kind, const IndiOptions& options, double period_s)
    : counts_(kind == LowLevel::crazyflie),
      options_(options),
      period_s_(period_s),
      mixer_(vehicle),
      lead_(vehicle, period_s) {
  if (counts_) {
    legacy_ = LegacyMixer(vehicle);
    torque_per_acceleration_ = (firmware_g1 + Vector3(0.0, 0.0, firmware_g2)).cwiseInverse().asDiagonal();
    yaw_g2_ = firmware_g2;
    limit_ = Vector3::Constant(firmware_torque_limit);
    actuator_follows_ = follows(firmware_actuator_lag_s, period_s);
  } else {
    torque_per_acceleration_ = vehicle.inertia_B_kgm2;
    limit_ = mixer_.torque_authority_B_Nm();
    // without a torque there is nothing to increment: three rotors leave yaw alone
    if (vehicle.rotor_count == 3) torque_per_acceleration_.row(2).setZero();
    actuator_follows_ = follows(lead_.lag_s(), period_s);
  }
}

void IndiAttitude::reset(const Observation& first) {
  rate_ = LowPass2<Vector3>(options_.filter_hz, period_s_, first.body_rate_B_radps);
  actuator_filter_ = LowPass2<Vector3>(options_.filter_hz, period_s_, Vector3::Zero());
  actuator_.setZero();
  last_yaw_increment_ = 0.0;
  lead_.reset(first.rotor_speed_radps);
}

RotorCommand IndiAttitude::update(const Observation& observation, const ThrustAttitude& wanted) {
  const Three error = attitude_error_B_rad(observation.attitude_WB, wanted.attitude_WB, 1.0);
  const Three wanted_rate = options_.attitude_gain * error + wanted.body_rate_B_radps;
  const Three wanted_acceleration = options_.rate_gain * (wanted_rate - observation.body_rate_B_radps);

  const Three before = rate_.value();
  const Three acceleration = (rate_.update(observation.body_rate_B_radps) - before) / period_s_;
  const Three torque_f = actuator_filter_.update(actuator_);

  // Δu = G1⁻¹ (ν − ω̇_f); yaw also feels the rotors speed up: (ν − ω̇_f + G2 Δu_prev)/(G1 + G2)
  Three missing = wanted_acceleration - acceleration;
  missing.z += yaw_g2_ * last_yaw_increment_;
  const Three increment = rotated(torque_per_acceleration_, missing);
  last_yaw_increment_ = increment.z;
  const Vector3 torque = limited(torque_f + increment, limit_);
  actuator_ = actuator_ + actuator_follows_ * (Three(torque) - actuator_);

  if (counts_) return legacy_.speeds(std::clamp(legacy_.pwm_of_total_thrust(wanted.thrust_N), 0.0, full_pwm), torque);
  return lead_.update(mixer_.speeds(wanted.thrust_N, torque));
}

IndiPosition::IndiPosition(const VehicleModel& vehicle, LowLevel kind, const IndiOptions& options, double period_s)
    : counts_(kind == LowLevel::crazyflie),
      options_(options),
      period_s_(period_s),
      mass_kg_(vehicle.mass_kg),
      gravity_mps2_(vehicle.gravity_mps2),
      legacy_(vehicle) {
  if (counts_) {
    acceleration_per_thrust_ = firmware_k_thrust;
    most_thrust_ = firmware_most_thrust;
    actuator_follows_ = follows(firmware_actuator_lag_s, period_s);
  } else {
    acceleration_per_thrust_ = 1.0 / mass_kg_;
    most_thrust_ = 0.9 * Mixer(vehicle).max_thrust_N();
    actuator_follows_ = follows(RotorLead(vehicle, period_s).lag_s(), period_s);
  }
}

void IndiPosition::reset(const Observation& first) {
  const EulerAngles angles = euler_angles(first.attitude_WB);
  specific_force_ = LowPass2<Vector3>(options_.filter_hz, period_s_, gravity_mps2_ * Vector3::UnitZ());
  angles_rad_ = LowPass2<Vector3>(options_.filter_hz, period_s_, {angles.roll_rad, angles.pitch_rad, angles.yaw_rad});
  last_yaw_rad_ = angles.yaw_rad;
  thrust_ = mass_kg_ * gravity_mps2_;
  if (counts_) thrust_ = legacy_.pwm_of_total_thrust(thrust_);
  wanted_thrust_ = thrust_;
  thrust_filter_ = LowPass2<double>(options_.filter_hz, period_s_, thrust_);
}

ThrustAttitude IndiPosition::update(const Observation& observation, const Reference& reference) {
  const Three wanted_velocity = options_.position_gain * (Three(reference.position_W_m) - observation.position_W_m);
  const Three wanted_acceleration = options_.velocity_gain * (wanted_velocity - observation.velocity_W_mps);

  // sensors through one filter; yaw is unwound so that it passes too
  const EulerAngles now = euler_angles(observation.attitude_WB);
  last_yaw_rad_ += wrapped(now.yaw_rad - last_yaw_rad_);
  const Three angles = angles_rad_.update({now.roll_rad, now.pitch_rad, last_yaw_rad_});
  const Three felt = specific_force_.update(observation.specific_force_B_mps2);
  Matrix3 R;
  const HalfAngle heading(angles.z);
  rotation_of(from_euler(HalfAngle(angles.x), HalfAngle(angles.y), heading), R);
  const Three missing = wanted_acceleration - (rotated(R, felt) - Three(0.0, 0.0, gravity_mps2_));

  // G = [g ∂(R e_z)/∂φ, g ∂(R e_z)/∂θ, R e_z]; turning by dφ about body x moves body z to −body y
  const Three level_y(-std::sin(angles.z), std::cos(angles.z), 0.0), up(R(0, 2), R(1, 2), R(2, 2));
  const Three by_roll = -gravity_mps2_ * Three(R(0, 1), R(1, 1), R(2, 1)),
              by_pitch = gravity_mps2_ * cross(level_y, up);
  const Three increment = times_pseudo_inverse(by_roll, by_pitch, up, missing);

  // thrust: what was asked for, through filter and actuator, plus the increment
  thrust_ += actuator_follows_ * (thrust_filter_.update(wanted_thrust_) - thrust_);
  wanted_thrust_ = std::clamp(thrust_ + increment.z / acceleration_per_thrust_, 0.0, most_thrust_);

  // roll and pitch are seen from the present heading
  const Quaternion tilted = from_euler(HalfAngle(limited(angles.x + increment.x, options_.tilt_limit_rad)),
                                       HalfAngle(limited(angles.y + increment.y, options_.tilt_limit_rad)), heading);
  return {counts_ ? legacy_.total_thrust_of_pwm(wanted_thrust_) : wanted_thrust_,
          attitude_along(turned(tilted, Three(0.0, 0.0, 1.0)), reference.yaw_rad)};
}

IndiForce::IndiForce(const VehicleModel& vehicle, const IndiOptions& options, double bandwidth_radps, double damping,
                     double period_s)
    : options_(options),
      period_s_(period_s),
      k_p_(bandwidth_radps * bandwidth_radps),
      k_v_(2.0 * damping * bandwidth_radps),
      mass_kg_(vehicle.mass_kg),
      gravity_mps2_(vehicle.gravity_mps2),
      mixer_(vehicle),
      model_follows_(follows(nominal_motor_lag_s(vehicle), period_s)) {}

void IndiForce::reset(const Observation& first) {
  acceleration_ = LowPass2<Vector3>(options_.filter_hz, period_s_, Vector3::Zero());
  thrust_ = LowPass2<Vector3>(options_.filter_hz, period_s_, mass_kg_ * gravity_mps2_ * Vector3::UnitZ());
  command_radps_ = model_speed_radps_ = first.rotor_speed_radps;
}

ThrustAttitude IndiForce::update(const Observation& observation, const Reference& reference) {
  for (std::size_t i = 0; i < model_speed_radps_.size(); ++i)
    model_speed_radps_[i] += model_follows_ * (command_radps_[i] - model_speed_radps_[i]);
  const Quaternion& q = observation.attitude_WB;
  const Vector3 thrust_f = thrust_.update(q * mixer_.force_B_N(model_speed_radps_));
  const Vector3 acceleration_f =
      acceleration_.update(q * observation.specific_force_B_mps2 - gravity_mps2_ * Vector3::UnitZ());
  const Vector3 wanted_acceleration = reference.acceleration_W_mps2 -
                                      k_p_ * (observation.position_W_m - reference.position_W_m) -
                                      k_v_ * (observation.velocity_W_mps - reference.velocity_W_mps);
  const Vector3 force = tilt_limited(thrust_f + mass_kg_ * (wanted_acceleration - acceleration_f),
                                     options_.tilt_limit_rad, 0.1 * mass_kg_ * gravity_mps2_);
  const double along_N = std::clamp(force.dot(q * Vector3::UnitZ()), 0.0, 0.95 * mixer_.max_thrust_N());
  return {along_N, attitude_along(force, reference.yaw_rad)};
}

}  // namespace gustlab
