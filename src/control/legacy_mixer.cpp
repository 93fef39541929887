#include "control/legacy_mixer.hpp"

#include <algorithm>

#include "util/three.hpp"

namespace gustlab {

LegacyMixer::LegacyMixer(const VehicleModel& vehicle) : count_(vehicle.rotor_count), pwm_(vehicle) {
  const auto side = [](double y_m) { return y_m > 0.0 ? 1.0 : -1.0; };
  for (int i = 0; i < count_; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    const Vector3 hub = rotor.position_B_m - vehicle.center_of_mass_B_m;
    share_[static_cast<std::size_t>(i)] = {0.5 * side(hub.y()), -0.5 * side(hub.x()), -rotor.direction};
    coefficient_sum_Ns2_ += rotor.thrust_coefficient_Ns2;
  }
}

double LegacyMixer::total_thrust_of_pwm(double pwm) const {
  const double speed = pwm_.speed_of_pwm(pwm);
  return coefficient_sum_Ns2_ * speed * speed;
}

RotorCommand LegacyMixer::speeds(double thrust_pwm, const Vector3& torque_pwm) const {
  RotorArray pwm{};
  double above = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
    pwm[i] = thrust_pwm + dot(share_[i], torque_pwm);
    above = std::max(above, pwm[i] - full_pwm);
  }
  RotorCommand command;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i)
    command.speed_radps[i] = pwm_.speed_of_pwm(std::clamp(pwm[i] - above, 0.0, full_pwm));
  return command;
}

}  // namespace gustlab
