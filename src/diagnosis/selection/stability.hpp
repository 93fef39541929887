// How surely a group is found: in which share of half samples a search anew chooses it.
#pragma once

#include <set>
#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Complementary halves of the clusters, each searched for sets of up to one more than was chosen; a share per catalogue group.
// Groups that are `left_out` are not asked.
std::vector<double> inclusion(const Session& session, const Grams& grams, const std::vector<int>& chosen,
                              const std::set<int>& left_out = {});

}  // namespace gustlab::diagnosis
