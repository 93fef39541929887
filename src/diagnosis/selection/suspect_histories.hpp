// Effects that are a history of each flight become columns when the disturbance looks like them: a swinging load, a lower
// speed limit.
#pragma once

#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Looks at what the (other) chosen groups leave, at `value`, and linearises anew where something is suspected.
void suspect_histories(Session& session, const Eigen::VectorXd& value, const std::vector<int>& chosen);
// The histories that were `fitted`, for other flights of the vehicle: a load swings as the vehicle flew there.
void suspect_histories_found(const Session& fitted, const Selection& selection, Session& session);

}  // namespace gustlab::diagnosis
