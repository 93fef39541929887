// how well the vehicle can be predicted, before and after the answer is known
#pragma once

#include <nlohmann/json.hpp>

#include "flight.hpp"

namespace reality {

/// Open-loop errors on one flight at 0.1, 0.5 and 1 s: of the vehicle file (`before`) and of the flown truth (`after`),
/// both started from noise-free readings and driven by the recorded commands, with no turbulence. Mean Euclidean or
/// geodesic errors, windows of one second without overlap.
nlohmann::ordered_json oracle(const Truth& before, const Truth& after, const Flight& flight);

}  // namespace reality
