// Commands of several rotors as one: their sum follows height and position, and is known where what each rotor did is not.
#pragma once

#include "gustlab/flight_log.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab::diagnosis {

// The log with the sum of its rotors' commands as its only input (collective_thrust), N. Unchanged when it has measured
// rotor speeds or no input of every rotor.
FlightLog with_total_thrust(FlightLog log, const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
