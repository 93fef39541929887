// Forces that every flight has for itself, and numbers of the vehicle that do the same.
#pragma once

#include <set>
#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// A set of groups in which a force of each flight (a wind, a constant force) is replaced by the one number of the vehicle that explains nearly
// as much: an upward force of one size in every flight is a thrust scale, or a mass. `grams`: coefficients counted from the nominal vehicle; groups that are
// `left_out` are not asked.
std::vector<int> shared_instead(const Session& session, const Grams& grams, std::vector<int> chosen,
                                const std::set<int>& left_out);

}  // namespace gustlab::diagnosis
