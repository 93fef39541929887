// Reading a vehicle: a name under models/ or a path to a vehicle.toml (FORMATS.md §2).
#pragma once

#include <string>
#include <vector>

#include "gustlab/vehicle.hpp"

namespace gustlab {

// `from_file`: a file whose folder relative paths resolve against; empty: the working directory.
// Throws ConfigError with file:line:col: unknown name with suggestion, broken MJCF, missing site, 3–8 rotors, …
VehicleModel read_vehicle(const std::string& name_or_path, const std::string& from_file = {});
// Names under models/.
std::vector<std::string> vehicle_names();
// A file or folder beside the source or install tree or in GUSTLAB_HOME; throws ConfigError when there is none.
std::string find_resource(const std::string& relative_path);

}  // namespace gustlab
