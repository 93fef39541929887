// Units of what an experiment sets, for the axes of pages.
#pragma once

#include <string>
#include <string_view>

#include "simulation/experiment.hpp"

namespace gustlab {

// Unit of the parameter that a dotted key of the experiment sets, as its declaration has it ("m/s"; "-" without a dimension); empty
// where nothing declares it.
std::string unit_of_setting(const Experiment& experiment, std::string_view key);

}  // namespace gustlab
