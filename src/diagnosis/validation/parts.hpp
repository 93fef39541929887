// An effect that both pushes and turns the vehicle does so in one proportion. What fits turning alone, where its push would be seen,
// is something else: rotors' damping between the samples of a slow log, not their inflow.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// How a finding's push compares with what its turning foretells: 1 + excess of it, and the standard error; 0 where one of the two is
// not seen.
struct Parts {
  double excess = 0.0, deviation = 0.0;
  bool damps = false;  // its turning answers the body rate
  // Damping in closed loop is seen up to 40 % too small (true inflows: 0.32 to 0.69), which makes a push too large, not too small;
  // apart from that, true effects of simulated trials were even to 0.34, and sticking motors taken for lagging ones at 0.59 and 0.70.
  bool uneven() const { return std::abs(excess) > std::max(excess < 0.0 ? 0.3 : damps ? 1.0 : 0.5, 3.0 * deviation); }
};
// Per finding, with everything else that was found free beside it, and trims as small as they are.
std::vector<Parts> parts(const Session& session, const Selection& selection);

}  // namespace gustlab::diagnosis
