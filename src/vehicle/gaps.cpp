#include "vehicle/gaps.hpp"

#include <fmt/format.h>

namespace gustlab {

std::string VehicleGap::says() const { return fmt::format("the vehicle file has no {} ({})", what, key); }

std::vector<VehicleGap> gaps_of(const VehicleModel& vehicle) {
  std::vector<VehicleGap> gaps;
  if (vehicle.rotor_radius_m == 0.0) gaps.push_back({Need::rotor_radius, "rotor radius", "[thrust] radius_m"});
  if (!vehicle.torque_ratio_known) gaps.push_back({Need::torque_ratio, "torque ratio of the rotors", "[thrust] torque_ratio"});
  if (!vehicle.rotor_speed_known) gaps.push_back({Need::rotor_speed, "rotor speed at hover", "[thrust] coefficient in place of hover"});
  return gaps;
}

}  // namespace gustlab
