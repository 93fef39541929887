// From [[effect]] tables to effects that fly.
#pragma once

#include <vector>

#include "gustlab/effect.hpp"

namespace gustlab {

// Throws ConfigError at the table: unknown type with suggestion, unknown key, range.
std::vector<NamedEffect> make_effects(const std::vector<EffectSpec>& specs);
// Those that act where a controller flies: without the habits of another.
std::vector<NamedEffect> make_flown_effects(const std::vector<EffectSpec>& specs);

}  // namespace gustlab
