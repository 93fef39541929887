// Is an effect the same wherever one looks? Physics holds at low and at high speed, in every flight, early and late; the
// shadow of something that no catalogue holds fits where it was seen and is of another size elsewhere.
#pragma once

#include <vector>

#include "diagnosis/result/findings.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Per finding: every variable's regimes, the widest spread first.
std::vector<std::vector<Regimes>> regimes(const Session& session, const Selection& selection);

// How much a finding's size may vary between regimes: the largest standard deviation, with two of its errors, of the variables whose
// regimes are known by more than a few clusters; 1 when those are not most.
double most_astray(const std::vector<Regimes>& regimes);

// Of the variables along which a finding's size differs by more than chance, the widest spread; 0 when there is none.
double surely_astray(const std::vector<Regimes>& regimes);

}  // namespace gustlab::diagnosis
