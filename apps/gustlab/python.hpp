// Scripts of the project, run in its Python environment.
#pragma once

#include <string>
#include <vector>

namespace gustlab {

// What a script under scripts/ prints. Its message is a DataError when it fails; without the environment a UserError says how
// to make it.
std::string output_of_script(const std::string& script, const std::vector<std::string>& arguments);

}  // namespace gustlab
