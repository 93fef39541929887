// An effect with both a force and a moment has them in one proportion. What fits the moment alone, where its force would be seen,
// is something else: rotors' damping between the samples of a slow log, not their inflow.
#pragma once

#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// How a finding's force compares with what its moment predicts: 1 + excess of it, and the standard error; 0 where one of the two is
// not seen.
struct Parts {
  double excess = 0.0, deviation = 0.0;
};
// Per finding, with everything else that was found free beside it, and trims as small as they are.
std::vector<Parts> parts(const Session& session, const Selection& selection);

}  // namespace gustlab::diagnosis
