// Declared parameters as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "gustlab/parameters.hpp"

namespace gustlab {

// [{name, unit, default, help, min, max}], without the limits that there are not.
nlohmann::ordered_json parameter_table(Parameterized& target);

}  // namespace gustlab
