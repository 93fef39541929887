// What a selection found, as numbers with their errors and as effects that fly.
#pragma once

#include "diagnosis/result/findings.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// The parameters of one group as they were fitted: of one flight, or (flight < 0) their mean over the flights.
std::vector<NamedValue> values_of(const Catalogue& catalogue, const Selection& selection, const Group& group,
                                  int flight);
// Every finding as an effect that flies, totals, in the order of the findings.
std::vector<EffectSpec> effects_found(const Catalogue& catalogue, const Selection& selection);

}  // namespace gustlab::diagnosis
