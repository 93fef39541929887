// Does the log contradict the vehicle file? Rotor order and directions come before any physics (DIAGNOSIS.md §3.9).
#pragma once

#include <vector>

#include "diagnosis/findings.hpp"

namespace gustlab::diagnosis {

// Corrects the vehicle's rotors where the flights say clearly that order or directions are others, and says so.
std::vector<LogFinding> check_rotors(const std::vector<FlightData>& flights, VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
