// What MuJoCo reads for a vehicle: the MJCF and the files that it names, in memory, from its folder and nowhere else.
#pragma once

#include <map>
#include <string>

namespace gustlab {

struct MjcfFiles {
  // by path from the folder of the MJCF; the MJCF itself under its own name
  std::map<std::string, std::string> bytes;
  std::string main;
};

// Reads the MJCF at `path`, and every file that it or an attached model names. Throws ConfigError with file:line for a
// file outside the folder, an <include>, and what is larger than a vehicle can be (docs/FORMATS.md, limits).
MjcfFiles read_mjcf_files(const std::string& path);

}  // namespace gustlab
