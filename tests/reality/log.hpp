// FlightLogs: only what a real recording has
#pragma once

#include <filesystem>
#include <string>

#include "flight.hpp"

namespace reality {

/// Writes `csv` and its sidecar; `vehicle` is the path of the vehicle file as the sidecar states it.
void write_log(const Flight& flight, const Surroundings& around, const Columns& columns, const std::string& vehicle,
               const std::filesystem::path& csv);

}  // namespace reality
