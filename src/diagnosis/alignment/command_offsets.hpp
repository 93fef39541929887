// Do the clocks of commands and motion agree from flight to flight?
#pragma once

#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

// Commands of some flights are stamped earlier than those of others: how much later each must be read, s, so that all agree
// with the promptest (fit flights first, then those held out), and a finding for each that must. A delay or lag that all share
// is physics, and stays.
std::vector<double> command_offsets(const std::vector<FlightData>& fit, const std::vector<FlightData>& held,
                                    const VehicleModel& vehicle, std::vector<LogFinding>& findings);

}  // namespace gustlab::diagnosis
