// What is shipped with the program, found from any working directory.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gustlab {

// Folders where models/, configs/ and experiments/ may be, most wanted first.
std::vector<std::filesystem::path> resource_homes();
// A file or folder beside the source or install tree or in GUSTLAB_HOME; throws ConfigError when there is none.
std::string find_resource(const std::string& relative_path);

}  // namespace gustlab
