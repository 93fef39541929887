// Which effects? Subset search over the catalogue on Gram matrices, refined in the nonlinear model.
#pragma once

#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

Selection select_effects(Session& session, const SelectionOptions& options);
// The same without some groups that did not prove themselves, fitted anew. What seemed not to pay beside them may take their place, but
// none of `banned`.
Selection withdraw(Session& session, const SelectionOptions& options, const Selection& before,
                   const std::vector<int>& groups, const std::vector<int>& banned);

}  // namespace gustlab::diagnosis
