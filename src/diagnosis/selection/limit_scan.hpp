// Does a rotor speed limit below the vehicle file's explain what the model misses?
#pragma once

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

struct LimitScan {
  double limit_radps = 0.0;
  double delta_chi2 = 0.0;  // of the whitened innovations, χ²
};
// Tries limits at the upper quantiles of the commanded speeds, with the given columns at their least-squares values.
LimitScan scan_limit(const Session& session, const std::vector<int>& columns);

}  // namespace gustlab::diagnosis
