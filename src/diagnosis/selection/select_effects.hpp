// Which effects? Subset search over the catalogue on Gram matrices, refined in the nonlinear model.
#pragma once

#include <optional>
#include <set>
#include <vector>

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

Selection select_effects(Session& session);
// The same, begun anew without the groups that have a value at its bound, until there are none (`at_bounds`): what they took is some other
// effect's, and a set that was found beside them is not near that.
Selection select_within_bounds(Session& session);
// The same without some groups that did not prove themselves, fitted anew. Groups that are `left_out` are not asked from here on.
Selection withdraw(Session& session, const Selection& before, const std::vector<int>& groups,
                   const std::set<int>& left_out = {});
// One group in place of another, fitted anew; what does not pay there goes.
Selection exchange(Session& session, const Selection& before, int group, int other, const std::set<int>& left_out = {});
// The same with more groups, fitted anew from `start` (SI, all columns); what does not pay there goes again.
Selection with_also(Session& session, const Selection& before, const std::vector<int>& groups,
                    const Eigen::VectorXd& start);
// Values (SI, all columns) of some groups, fitted from `start`; none of them goes.
Eigen::VectorXd values_with(Session& session, const std::vector<int>& groups, const Eigen::VectorXd& start);
// The same with what pays beside it now, because others have gone since; nothing when nothing does. A set of groups that
// was `tried` is not tried again.
std::optional<Selection> look_again(Session& session, const Selection& before, std::set<std::vector<int>>& tried,
                                    const std::set<int>& left_out = {});

}  // namespace gustlab::diagnosis
