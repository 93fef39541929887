#pragma once

#include <CLI/CLI.hpp>

namespace gustlab {

// Adds `fit` to the group `vehicle`.
void add_vehicle_fit(CLI::App& group);

}  // namespace gustlab
