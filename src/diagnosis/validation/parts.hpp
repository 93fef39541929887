// An effect with both a force and a moment has them in one proportion. What fits the moment alone, where its force would be seen,
// is something else: rotors' damping between the samples of a slow log, not their inflow.
#pragma once

#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// How a finding's force compares with its moment. Fitted apart they have `excess` between them, in sizes of the finding (> 0: the force is the
// larger one), with its standard error. `lacking`: how much smaller than the finding the smaller of the two is; what the other one has
// beyond it is of something else. All 0 where one of the two is not seen.
struct Parts {
  double excess = 0.0, deviation = 0.0, lacking = 0.0;
};
// Per finding, with everything else that was found free beside it, and trims as small as they are.
std::vector<Parts> parts(const Session& session, const Selection& selection);

}  // namespace gustlab::diagnosis
