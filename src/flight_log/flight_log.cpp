#include "gustlab/flight_log.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gustlab {

std::string_view to_string(ActuatorKind kind) {
  switch (kind) {
    case ActuatorKind::rotor_speed:
      return "rotor_speed";
    case ActuatorKind::thrust:
      return "thrust";
    case ActuatorKind::throttle:
      return "throttle";
    case ActuatorKind::pwm:
      return "pwm";
    case ActuatorKind::collective_thrust:
      return "collective_thrust";
  }
  return "?";
}

std::string_view to_string(Hold hold) {
  switch (hold) {
    case Hold::unknown:
      return "unknown";
    case Hold::zoh:
      return "zoh";
    case Hold::linear:
      return "linear";
  }
  return "?";
}

bool is_rotor_column(std::string_view name) {
  const std::size_t prefix = name.starts_with("rotor") ? 5 : name.starts_with("u") ? 1 : name.size();
  return prefix < name.size() && name.find_first_not_of("0123456789", prefix) == std::string_view::npos;
}

const std::vector<double>* FlightLog::find(std::string_view name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [name](const auto& c) { return c.name == name; });
  return found == columns.end() ? nullptr : &found->values;
}

int FlightLog::count(std::string_view prefix) const {
  int n = 0;
  while (has(fmt::format("{}{}", prefix, n + 1))) ++n;
  return n;
}

}  // namespace gustlab
