// Does a rotor speed limit below the vehicle file's explain the disturbance?
#pragma once

#include "diagnosis/session.hpp"

namespace gustlab::diagnosis {

struct LimitScan {
  double limit_radps = 0.0;
  double gain = 0.0;        // of the smoothed disturbance, in squared standard deviations per correlation time
};
// Tries limits at the upper quantiles of the commanded speeds.
LimitScan scan_limit(const Session& session);

}  // namespace gustlab::diagnosis
