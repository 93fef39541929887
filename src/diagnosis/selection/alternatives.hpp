// Other sets than the one that stands: one effect in place of some that together do what it does alone.
#pragma once

#include <set>
#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Sets of groups with another effect in place of one, two or three findings, where it keeps at least as much of what they gain together as
// a rival must (decisions::most_lost_to_rival); the likeliest of every such effect, and of these the likeliest few, best first. By the Gram
// matrices of the selection. Groups that are `left_out` are not asked, nor what cannot be told from the finding whose place it takes, nor values of
// every flight's own, which fit every flight.
std::vector<std::vector<int>> alternatives(const Session& session, const Selection& standing,
                                           const std::set<int>& left_out);

}  // namespace gustlab::diagnosis
