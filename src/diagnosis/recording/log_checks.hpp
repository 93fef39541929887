// Faults of a log that come before any physics: what is not usable is set aside, and said.
#pragma once

#include <vector>

#include "diagnosis/result/findings.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// Looks at one flight and takes out of it what cannot be used (samples become NaN, rows on the ground go). A finding with
// sets_flight_aside says that nothing is left to use.
std::vector<LogFinding> check_log(FlightLog& log, const VehicleModel& vehicle);
// Flights that are copies of an earlier one, of these or of those `before`, are set aside.
std::vector<LogFinding> check_copies(const std::vector<FlightLog>& logs,
                                     const std::vector<const FlightLog*>& before = {});

}  // namespace gustlab::diagnosis
