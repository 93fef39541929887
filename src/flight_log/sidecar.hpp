// NAME.meta.toml: what a flight log's columns mean (FORMATS.md §1).
#pragma once

#include <string>

#include "gustlab/flight_log.hpp"

namespace gustlab {

// Throws DataError with file:line:col.
LogMeta read_sidecar(const std::string& path);
std::string sidecar_text(const LogMeta& meta);

}  // namespace gustlab
