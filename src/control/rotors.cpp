#include "control/rotors.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>
#include <utility>

namespace gustlab {

Mixer::Mixer(const VehicleModel& vehicle) : count_(vehicle.rotor_count) {
  for (int i = 0; i < count_; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    const Vector3 hub = rotor.position_B_m - vehicle.center_of_mass_B_m;
    wrench_of_thrust_.col(i) << rotor.axis_B,
        hub.cross(rotor.axis_B) - rotor.direction * rotor.torque_ratio_m * rotor.axis_B;
    coefficient_Ns2_[i] = rotor.thrust_coefficient_Ns2;
    max_thrust_N_[i] = rotor.thrust_coefficient_Ns2 * vehicle.max_speed_radps * vehicle.max_speed_radps;
  }

  // in units of weight and weight × arm, so that the threshold on singular values means something
  const double arm_m = vehicle.arm_m();
  Eigen::Vector4d scale(1.0, 1.0 / arm_m, 1.0 / arm_m, count_ > 3 ? 1.0 / arm_m : 0.0);
  Eigen::Matrix<double, 4, Eigen::Dynamic> matrix(4, count_);
  matrix << wrench_of_thrust_.row(2).head(count_), wrench_of_thrust_.bottomRows<3>().leftCols(count_);
  const Eigen::MatrixXd inverse = (scale.asDiagonal() * matrix).completeOrthogonalDecomposition().pseudoInverse();
  thrust_of_wrench_.topRows(count_) = inverse * scale.asDiagonal();

  max_total_N_ = wrench_of_thrust_.row(2).dot(max_thrust_N_);
  const Thrusts hover = thrust_of_wrench_.col(0) * vehicle.weight_N();
  for (int axis = 0; axis < 3; ++axis) {
    double least = 1e300;
    for (int i = 0; i < count_; ++i) {
      const double share = std::abs(thrust_of_wrench_(i, axis + 1));
      if (share > 0.0) least = std::min(least, std::min(hover[i], max_thrust_N_[i] - hover[i]) / share);
    }
    authority_B_Nm_[axis] = least < 1e300 ? std::max(least, 0.0) : 0.0;
  }
}

double Mixer::speed_of(int rotor, double thrust_N) const {
  const double within = std::clamp(thrust_N, 0.0, max_thrust_N_[rotor]);
  return std::sqrt(within / coefficient_Ns2_[rotor]);
}

RotorCommand Mixer::speeds(double thrust_N, const Vector3& torque_B_Nm) const {
  const auto lift = thrust_of_wrench_.col(0);
  Thrusts tilt = thrust_of_wrench_.middleCols<2>(1) * torque_B_Nm.head<2>();
  const Thrusts turn = thrust_of_wrench_.col(3) * torque_B_Nm.z();

  // collective thrusts that keep every rotor between its limits
  const auto fitting = [&] {
    std::pair<double, double> range{0.0, 1e300};
    for (int i = 0; i < count_; ++i) {
      if (lift[i] <= 1e-12) continue;
      range.first = std::max(-tilt[i] / lift[i], range.first);
      range.second = std::min((max_thrust_N_[i] - tilt[i]) / lift[i], range.second);
    }
    return range;
  };
  auto [low, high] = fitting();
  // roll and pitch shrink until there is one
  if (low > high) {
    tilt *= max_total_N_ / (max_total_N_ + low - high);
    std::tie(low, high) = fitting();
  }
  // thrust yields to roll and pitch
  const double collective_N = low > high ? 0.5 * (low + high) : std::clamp(thrust_N, low, high);

  // yaw takes what is left
  Thrusts thrusts = tilt + collective_N * lift;
  double share = 1.0;
  for (int i = 0; i < count_; ++i) {
    const double room = turn[i] > 0.0 ? max_thrust_N_[i] - thrusts[i] : thrusts[i];
    if (std::abs(turn[i]) > room) share = std::min(share, std::max(room, 0.0) / std::abs(turn[i]));
  }
  thrusts += share * turn;

  RotorCommand command;
  for (int i = 0; i < count_; ++i) command.speed_radps[static_cast<std::size_t>(i)] = speed_of(i, thrusts[i]);
  return command;
}

Vector3 Mixer::force_B_N(const RotorArray& speed_radps) const {
  Vector3 force = Vector3::Zero();
  for (int i = 0; i < count_; ++i) {
    const double speed = speed_radps[static_cast<std::size_t>(i)];
    force += coefficient_Ns2_[i] * speed * speed * wrench_of_thrust_.col(i).head<3>();
  }
  return force;
}

Vector3 Mixer::torque_B_Nm(const RotorArray& speed_radps) const {
  Vector3 torque = Vector3::Zero();
  for (int i = 0; i < count_; ++i) {
    const double speed = speed_radps[static_cast<std::size_t>(i)];
    torque += coefficient_Ns2_[i] * speed * speed * wrench_of_thrust_.col(i).tail<3>();
  }
  return torque;
}

double nominal_motor_lag_s(const VehicleModel& vehicle) {
  for (const EffectSpec& effect : vehicle.effects)
    if (effect.type == "motor_lag")
      for (const auto& [key, value] : effect.values)
        if (key == "time_constant") return std::strtod(value.c_str(), nullptr);
  return 0.0;
}

PwmMap::PwmMap(const VehicleModel& vehicle) : coefficient_Ns2_(vehicle.rotors[0].thrust_coefficient_Ns2) {
  if (vehicle.actuator.pwm_line) {
    line_ = vehicle.actuator.pwm_line;
  } else if (vehicle.actuator.pwm_thrust) {
    polynomial_ = *vehicle.actuator.pwm_thrust;
  } else {
    // CrazySim's Crazyflie hovers at pwm 38781 of 65535
    constexpr double hover_pwm = 38781.0;
    const double hover = vehicle.hover_speed_radps();
    // without a limit speed is proportional to the command
    const bool limited = std::isfinite(vehicle.max_speed_radps);
    const double slope = limited ? (vehicle.max_speed_radps - hover) / (full_pwm - hover_pwm) : hover / hover_pwm;
    line_ = {slope, hover - slope * hover_pwm};
  }
}

double PwmMap::pwm_of_thrust(double thrust_N) const {
  const double thrust = thrust_N < 0.0 ? 0.0 : thrust_N;
  if (line_) return (std::sqrt(thrust / coefficient_Ns2_) - line_->second) / line_->first;
  const auto& [c0, c1, c2] = polynomial_;
  if (c2 == 0.0) return (thrust - c0) / c1;
  return (-c1 + std::sqrt(std::max(c1 * c1 - 4.0 * c2 * (c0 - thrust), 0.0))) / (2.0 * c2);
}

double PwmMap::speed_of_pwm(double pwm) const {
  if (line_) return line_->first * pwm + line_->second;
  const auto& [c0, c1, c2] = polynomial_;
  return std::sqrt(std::max(c0 + (c1 + c2 * pwm) * pwm, 0.0) / coefficient_Ns2_);
}

}  // namespace gustlab
