#include "vehicle/gaps.hpp"

#include <fmt/format.h>

namespace gustlab {

std::string VehicleGap::says() const { return fmt::format("the vehicle file has no {} ({})", what, key); }

std::vector<VehicleGap> gaps_of(const VehicleModel& vehicle) {
  std::vector<VehicleGap> gaps;
  if (vehicle.rotor_radius_m == 0.0) gaps.push_back({Need::rotor_radius, "rotor radius", "[thrust] radius_m"});
  if (!vehicle.torque_ratio_known)
    gaps.push_back({Need::torque_ratio, "torque ratio of the rotors", "[thrust] torque_ratio"});
  if (!vehicle.rotor_speed_known)
    gaps.push_back({Need::rotor_speed, "rotor speed at hover", "[thrust] coefficient in place of hover"});
  return gaps;
}

void assume_nominal_voltage(VehicleModel& vehicle, const FlightLog& first) {
  const std::vector<double>* voltage = first.find("vbat");
  if (vehicle.nominal_voltage_V > 0.0 || voltage == nullptr) return;
  double sum = 0.0, count = 0.0;
  for (const double volts : *voltage)
    if (volts > 0.0) sum += volts, count += 1.0;
  if (count > 0.0) vehicle.nominal_voltage_V = sum / count;
}

}  // namespace gustlab
