// Reading a vehicle: a name under models/ or a path to a vehicle.toml or its folder (FORMATS.md §2).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/resources.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// `from_file`: a file whose folder relative paths resolve against; empty: the working directory.
// Throws ConfigError with file:line:col: unknown name with suggestion, broken MJCF, missing site, 3–8 rotors, …
VehicleModel read_vehicle(const std::string& name_or_path, const std::string& from_file = {});
// A flight log and the vehicle that its sidecar names.
struct FlownBy {
  std::string flight, vehicle;
};
// The one vehicle of flights that come one after the other.
class OneVehicle {
 public:
  // Reads the first flight's. Throws DataError where another names a vehicle whose files differ, and ConfigError as above. One that
  // names none flew with the first's, and so did one that says the same words in a folder without that vehicle.
  const VehicleModel& of(const FlownBy& flight);

 private:
  FlownBy first_;
  std::optional<VehicleModel> vehicle_;
};
// Names under models/.
std::vector<std::string> vehicle_names();

}  // namespace gustlab
