// What was selected must pay on flights that were not used, and be of one size wherever one looks.
#pragma once

#include <vector>

#include "diagnosis/result/findings.hpp"
#include "diagnosis/validation/holdout.hpp"
#include "diagnosis/validation/parts.hpp"
#include "diagnosis/validation/regimes.hpp"

namespace gustlab::diagnosis {

struct Challenge {
  HoldoutTest tested;                          // of the findings that are left
  std::vector<std::vector<Regimes>> regimes;   // of each of them, the widest spread first
  std::vector<Rejected> withdrawn;
  bool uneven = false;                         // one of them for being uneven
};

// Findings that fail are withdrawn and the rest is fitted anew, until what is left stands. `held_own_rate`: the held-out
// flights as they were logged, when the fit was by shooting. `least_included`: share of halves of the data that must name it.
Challenge challenge(Session& session, Selection& selection, const std::vector<FlightData>& held,
                    const std::vector<FlightData>& held_own_rate, double least_included, int jobs);

}  // namespace gustlab::diagnosis
