// How surely a group is found: in which share of half samples a search anew chooses it.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Complementary halves of the clusters, each searched for sets of up to one more than was chosen; a share per catalogue group.
// Groups that are `left_out` are not asked. `equals`: of a chosen group, those that stand for it where it was not chosen itself.
std::vector<double> inclusion(const Session& session, const Grams& grams, const std::vector<int>& chosen,
                              const std::set<int>& left_out = {}, const std::map<int, std::vector<int>>& equals = {});

}  // namespace gustlab::diagnosis
