// Streams that were recorded on clocks of their own: does the time between them stay the same along a flight?
#pragma once

#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

// One `delay` finding per stretch of time in which the gyro keeps the same offset from the attitude's rate, when it jumps
// within the flight; empty when it does not. `pose`: the flight read without its gyro; rate_B_radps: gyro per sample, NaN
// where it has none.
std::vector<LogFinding> rate_delays(const FlightData& pose, const std::vector<Vector3>& rate_B_radps);

// Whether in one of the flights the commands cannot be laid beside the motion: `findings` has delays of its gyro, and the
// pose alone does not say clearly that roll and pitch follow the rotors by one time (where that jumps, too, there is one
// more `delay` finding per stretch).
bool clocks_apart(const std::vector<FlightData>& flights, const VehicleModel& vehicle, std::vector<LogFinding>& findings);

// The log with the sum of its rotors' commands as its only input (collective_thrust), N. Unchanged when it has measured
// rotor speeds or no input of every rotor.
FlightLog with_total_thrust(FlightLog log, const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
