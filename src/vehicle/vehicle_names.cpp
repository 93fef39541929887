#include <algorithm>
#include <filesystem>

#include "vehicle/read_vehicle.hpp"

namespace gustlab {

std::vector<std::string> vehicle_names() {
  std::vector<std::string> names;
  for (const std::filesystem::path& home : resource_homes()) {
    std::error_code error;
    for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(home / "models", error))
      if (std::filesystem::exists(entry.path() / "vehicle.toml", error))
        names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace gustlab
