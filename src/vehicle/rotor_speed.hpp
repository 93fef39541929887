// Actuator inputs of a log as rotor speeds (FORMATS.md §1, §2).
#pragma once

#include "gustlab/flight_log.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// Speed that `input` asks of a rotor, rad/s. Throws DataError when the vehicle has no map for this kind of input.
double rotor_speed_radps(const VehicleModel& vehicle, const Rotor& rotor, ActuatorKind kind, double input);

// All rotors' thrust at these speeds, N.
double thrust_N(const VehicleModel& vehicle, const RotorArray& speed_radps);

}  // namespace gustlab
