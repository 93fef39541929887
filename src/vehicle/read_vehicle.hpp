// Reading a vehicle: a name under models/ or a path to a vehicle.toml or its folder (FORMATS.md §2).
#pragma once

#include <string>
#include <vector>

#include "config/resources.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// `from_file`: a file whose folder relative paths resolve against; empty: the working directory.
// Throws ConfigError with file:line:col: unknown name with suggestion, broken MJCF, missing site, 3–8 rotors, …
VehicleModel read_vehicle(const std::string& name_or_path, const std::string& from_file = {});
// Names under models/.
std::vector<std::string> vehicle_names();

}  // namespace gustlab
