#include "gustlab/vehicle.hpp"

#include <cmath>

namespace gustlab {

double VehicleModel::hover_speed_radps() const {
  double coefficient = 0.0;
  for (int i = 0; i < rotor_count; ++i) coefficient += rotors[static_cast<std::size_t>(i)].thrust_coefficient_Ns2;
  return std::sqrt(hover_thrust_N() * rotor_count / coefficient);
}

double VehicleModel::arm_m() const {
  double sum = 0.0;
  for (int i = 0; i < rotor_count; ++i)
    sum += (rotors[static_cast<std::size_t>(i)].position_B_m - center_of_mass_B_m).head<2>().norm();
  return sum / rotor_count;
}

}  // namespace gustlab
