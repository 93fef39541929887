// Effects that are a history of each flight become columns when the disturbance looks like them: a swinging load, a lower
// speed limit.
#pragma once

#include <vector>

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

// Looks at what the (other) chosen groups leave, at `value`, and linearises anew where something is suspected.
void suspect_histories(Session& session, const Eigen::VectorXd& value, const std::vector<int>& chosen);

}  // namespace gustlab::diagnosis
