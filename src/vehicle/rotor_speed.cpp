#include "vehicle/rotor_speed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "gustlab/errors.hpp"

namespace gustlab {

double rotor_speed_radps(const VehicleModel& vehicle, const Rotor& rotor, ActuatorKind kind, double input) {
  // of an input that is not a number (a row without a command) neither is the speed: std::max keeps its first argument
  const auto from_thrust = [&](double thrust_N) {
    return std::sqrt(std::max(thrust_N, 0.0) / rotor.thrust_coefficient_Ns2);
  };
  const auto mapped = [&](const auto& line, const auto& thrust) -> std::optional<double> {
    if (line) return input <= 0.0 ? 0.0 : line->first * input + line->second;
    if (thrust) return from_thrust((*thrust)[0] + input * ((*thrust)[1] + input * (*thrust)[2]));
    return std::nullopt;
  };
  std::optional<double> speed;
  switch (kind) {
    case ActuatorKind::rotor_speed:
      return input;
    case ActuatorKind::thrust:
      return from_thrust(input);
    case ActuatorKind::collective_thrust:
      return from_thrust(input / vehicle.rotor_count);
    case ActuatorKind::throttle:
      speed = mapped(vehicle.actuator.throttle_line, vehicle.actuator.throttle_thrust);
      // without a map full throttle is full speed
      if (!speed && std::isfinite(vehicle.max_speed_radps)) return input * vehicle.max_speed_radps;
      break;
    case ActuatorKind::pwm:
      speed = mapped(vehicle.actuator.pwm_line, vehicle.actuator.pwm_thrust);
      break;
  }
  if (speed) return *speed;
  throw DataError(fmt::format(
      "{}: nothing says what {} does (the log's inputs are {}); add [actuator] {} or {}_thrust, or [thrust] hover",
      vehicle.source_path, to_string(kind), to_string(kind), to_string(kind), to_string(kind)));
}

RotorArray speeds_radps(const VehicleModel& vehicle, ActuatorKind kind,
                        const std::function<double(std::size_t)>& input) {
  RotorArray speeds{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(vehicle.rotor_count); ++i)
    speeds[i] = rotor_speed_radps(vehicle, vehicle.rotors[i], kind, input(i));
  return speeds;
}

double thrust_N(const VehicleModel& vehicle, const RotorArray& speed_radps) {
  double sum = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(vehicle.rotor_count); ++i)
    sum += vehicle.rotors[i].thrust_coefficient_Ns2 * std::pow(speed_radps[i], 2);
  return sum;
}

}  // namespace gustlab
