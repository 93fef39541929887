#include "config/resources.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace fs = std::filesystem;

std::vector<fs::path> resource_homes() {
  std::vector<fs::path> result;
  if (const char* home = std::getenv("GUSTLAB_HOME"); home != nullptr && *home != '\0') result.emplace_back(home);
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) result.push_back(program.parent_path().parent_path() / "share" / "gustlab");
  result.emplace_back(source_directory());
  return result;
}

std::string find_resource(const std::string& relative_path) {
  for (const fs::path& home : resource_homes())
    if (std::error_code error; fs::exists(home / relative_path, error)) return (home / relative_path).string();
  throw ConfigError(
      fmt::format("{}: not found (neither in GUSTLAB_HOME nor beside the program or its source); "
                  "set GUSTLAB_HOME to the folder that holds models/",
                  relative_path));
}

}  // namespace gustlab
