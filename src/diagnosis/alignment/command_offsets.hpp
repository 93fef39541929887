// Do the clocks of commands and motion agree from flight to flight?
#pragma once

#include <functional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

// Whether a flight's likelihood peaks where its commands are read so much later. `gain`: by how much twice its logarithm rises at a time, s.
// In rough air commands answer what the vehicle is about to do: read at another time they say more of it, whatever that time is.
bool is_likeliest(double later_s, const std::function<double(double)>& gain);

// Commands of some flights are stamped earlier than those of others: how much later each must be read, s, so that all agree
// with the promptest (fit flights first, then those held out), and a finding for each that must. A delay or lag that all share
// is physics, and stays.
std::vector<double> command_offsets(const std::vector<FlightData>& fit, const std::vector<FlightData>& held,
                                    const VehicleModel& vehicle, std::vector<LogFinding>& findings);

}  // namespace gustlab::diagnosis
