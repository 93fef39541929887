// Actuator inputs of a log as rotor speeds (FORMATS.md §1, §2).
#pragma once

#include <functional>

#include "gustlab/flight_log.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// Speed that `input` asks of a rotor, rad/s. Throws DataError when the vehicle has no map for this kind of input.
double rotor_speed_radps(const VehicleModel& vehicle, const Rotor& rotor, ActuatorKind kind, double input);

// Those that the inputs of a row ask for; `input(i)` is that of rotor i, from 0.
RotorArray speeds_radps(const VehicleModel& vehicle, ActuatorKind kind,
                        const std::function<double(std::size_t)>& input);

// All rotors' thrust at these speeds, N.
double thrust_N(const VehicleModel& vehicle, const RotorArray& speed_radps);

}  // namespace gustlab
