// From thrust and torque to rotor speeds, by the vehicle's own geometry: 3 to 8 rotors, wherever they sit.
#pragma once

#include "gustlab/vehicle.hpp"

namespace gustlab {

// Thrusts that give [thrust along body z, torque about the centre of mass], least squares; with three rotors, whose yaw
// torque is not free, roll and pitch come first.
class Mixer {
 public:
  Mixer() = default;
  explicit Mixer(const VehicleModel& vehicle);

  // Rotor speeds, each within 0 and the vehicle's limit. When a limit is met, yaw torque yields first, then thrust, then
  // roll and pitch torque in proportion.
  RotorCommand speeds(double thrust_N, const Vector3& torque_B_Nm) const;
  double speed_of(int rotor, double thrust_N) const;

  // What rotors at these speeds push: thrust along each axis added up, body axes.
  Vector3 force_B_N(const RotorArray& speed_radps) const;
  Vector3 torque_B_Nm(const RotorArray& speed_radps) const;

  int count() const { return count_; }
  double max_thrust_N() const { return max_total_N_; }
  // largest torque about an axis, at hover thrust, that no limit cuts
  Vector3 torque_authority_B_Nm() const { return authority_B_Nm_; }

 private:
  using Thrusts = Eigen::Matrix<double, max_rotors, 1>;
  int count_ = 0;
  Eigen::Matrix<double, 6, max_rotors> wrench_of_thrust_ = Eigen::Matrix<double, 6, max_rotors>::Zero();
  Eigen::Matrix<double, max_rotors, 4> thrust_of_wrench_ = Eigen::Matrix<double, max_rotors, 4>::Zero();
  Thrusts coefficient_Ns2_ = Thrusts::Ones();
  Thrusts max_thrust_N_ = Thrusts::Zero();
  double max_total_N_ = 0.0;
  Vector3 authority_B_Nm_ = Vector3::Zero();
};

// Seconds that the nominal rotors take to follow: the motor_lag effect in the vehicle file, 0 when there is none.
double nominal_motor_lag_s(const VehicleModel& vehicle);

// Between thrust and pwm of one rotor (FORMATS.md §2 [actuator]); a vehicle without such a map gets a line in speed through
// hover at the Crazyflie's hover pwm.
class PwmMap {
 public:
  PwmMap() = default;
  explicit PwmMap(const VehicleModel& vehicle);
  double pwm_of_thrust(double thrust_N) const;  // may lie outside 0..full_pwm
  double speed_of_pwm(double pwm) const;

 private:
  double coefficient_Ns2_ = 1.0;
  std::optional<std::pair<double, double>> line_;
  std::array<double, 3> polynomial_{};
};

}  // namespace gustlab
