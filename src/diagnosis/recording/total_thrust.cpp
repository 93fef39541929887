#include "diagnosis/recording/total_thrust.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "vehicle/rotor_speed.hpp"

namespace gustlab::diagnosis {

FlightLog with_total_thrust(FlightLog log, const VehicleModel& vehicle) {
  std::vector<std::vector<double>*> input;
  for (LogColumn& column : log.columns) {
    if (column.name == "rotor1") return log;
    for (int i = 1; i <= vehicle.rotor_count; ++i)
      if (column.name == fmt::format("u{}", i)) input.push_back(&column.values);
  }
  if (input.size() != static_cast<std::size_t>(vehicle.rotor_count) ||
      log.meta.actuator == ActuatorKind::collective_thrust)
    return log;
  std::vector<double> total(log.rows());
  for (std::size_t i = 0; i < input.size(); ++i)
    for (std::size_t k = 0; k < log.rows(); ++k) {
      const Rotor& rotor = vehicle.rotors[i];
      total[k] += rotor.thrust_coefficient_Ns2 *
                  std::pow(rotor_speed_radps(vehicle, rotor, log.meta.actuator, (*input[i])[k]), 2);
    }
  *input.front() = std::move(total);
  log.meta.actuator = ActuatorKind::collective_thrust;
  std::erase_if(log.columns, [](const LogColumn& column) {
    return column.name.size() == 2 && column.name[0] == 'u' && column.name[1] != '1';
  });
  return log;
}

}  // namespace gustlab::diagnosis
