// [thrust] and [actuator] of a vehicle file: what inputs do to rotors (FORMATS.md §2).
#pragma once

#include "config/toml.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// Collects what is wrong with single keys of [thrust] and [actuator]; that they fit together is for read_thrust().
void check_thrust(config::Table& document, config::Problems& problems);

// Fills thrust coefficients, torque ratios, limits and actuator maps of a vehicle whose mass, gravity and rotors are known;
// `own_coefficient`: of each rotor, where its table says one. What is optional and absent is estimated or unknown, see
// VehicleModel. Throws ConfigError with file:line:col.
void read_thrust(config::Table& document, const std::vector<std::optional<double>>& own_coefficient,
                 VehicleModel& vehicle);

// A number that must be above zero; std::nullopt when absent.
std::optional<double> positive(config::Table& table, std::string_view key);

}  // namespace gustlab
