// Writes a flight log that may be long.
#pragma once

#include <functional>
#include <string>

#include "gustlab/flight_log.hpp"

namespace gustlab {

// As write_flight_log. `between` is called between rows, now and then; what it throws ends the writing, and nothing is left.
void write_flight_log(const FlightLog& log, const std::string& csv_path, const std::function<void()>& between);

}  // namespace gustlab
