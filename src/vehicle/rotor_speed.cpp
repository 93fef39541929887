#include "vehicle/rotor_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gustlab/errors.hpp"

namespace gustlab {

double rotor_speed_radps(const VehicleModel& vehicle, const Rotor& rotor, ActuatorKind kind, double input) {
  const auto from_thrust = [&](double thrust_N) {
    return std::sqrt(std::max(0.0, thrust_N) / rotor.thrust_coefficient_Ns2);
  };
  switch (kind) {
    case ActuatorKind::rotor_speed:
      return input;
    case ActuatorKind::thrust:
      return from_thrust(input);
    case ActuatorKind::throttle:
      return input * vehicle.max_speed_radps;
    case ActuatorKind::collective_thrust:
      return from_thrust(input / vehicle.rotor_count);
    case ActuatorKind::pwm:
      break;
  }
  if (vehicle.actuator.pwm_line)
    return input <= 0.0 ? 0.0 : vehicle.actuator.pwm_line->first * input + vehicle.actuator.pwm_line->second;
  if (vehicle.actuator.pwm_thrust) {
    const auto& c = *vehicle.actuator.pwm_thrust;
    return from_thrust(c[0] + input * (c[1] + input * c[2]));
  }
  throw DataError(
      fmt::format("{}: no [actuator] pwm map (the log's inputs are pwm) add pwm or pwm_thrust", vehicle.source_path));
}

}  // namespace gustlab
