#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;

// where models/, configs/ and experiments/ may be, most wanted first
std::vector<fs::path> homes() {
  std::vector<fs::path> result;
  if (const char* home = std::getenv("GUSTLAB_HOME"); home != nullptr && *home != '\0') result.emplace_back(home);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) result.push_back(program.parent_path().parent_path() / "share" / "gustlab");
  result.emplace_back(source_directory());
  return result;
}

}  // namespace

std::string find_resource(const std::string& relative_path) {
  for (const fs::path& home : homes())
    if (std::error_code error; fs::exists(home / relative_path, error)) return (home / relative_path).string();
  throw ConfigError(fmt::format("{}: not found (neither in GUSTLAB_HOME nor beside the program or its source) "
                                "set GUSTLAB_HOME to the folder that holds models/", relative_path));
}

std::vector<std::string> vehicle_names() {
  std::vector<std::string> names;
  for (const fs::path& home : homes()) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(home / "models", error))
      if (fs::exists(entry.path() / "vehicle.toml", error)) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace gustlab
