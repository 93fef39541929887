// Linear constraints on coefficients, as text: `fx[T sin theta] + fy[T sin phi] = 0`.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/feature_terms.hpp"
#include "identification/optimizer.hpp"

namespace gustlab {

// Reads `a target[term] ± b target[term] … = d` (`2*fz[1] - fz[T cos theta] = -0.5`), one constraint per text.
// Throws ConfigError when a text is none, or names a target or a term that is not in the problem.
LinearConstraints parse_constraints(std::span<const std::string> texts, std::span<const FeatureTerm> terms,
                                    std::span<const std::string_view> targets);

}  // namespace gustlab
