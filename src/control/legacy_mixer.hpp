// The Crazyflie's legacy mixer (power_distribution_quadrotor): a thrust and three torques, all in counts of a 16 bit motor
// scale, to pwm and from there to rotor speed. Half of roll and pitch goes to the rotors of each side, all of yaw to all.
#pragma once

#include "control/rotors.hpp"

namespace gustlab {

class LegacyMixer {
 public:
  LegacyMixer() = default;
  explicit LegacyMixer(const VehicleModel& vehicle);

  double pwm_of_total_thrust(double thrust_N) const { return pwm_.pwm_of_thrust(thrust_N / count_); }
  double total_thrust_of_pwm(double pwm) const;
  // Counts above the scale are taken from every rotor alike; below it they are cut.
  RotorCommand speeds(double thrust_pwm, const Vector3& torque_pwm) const;

 private:
  int count_ = 0;
  double coefficient_sum_Ns2_ = 0.0;
  PwmMap pwm_;
  std::array<Vector3, max_rotors> share_;
};

}  // namespace gustlab
