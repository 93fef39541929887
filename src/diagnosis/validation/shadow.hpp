// While something stays unexplained, a name may be its shadow: which names stand all the same (DIAGNOSIS.md §3.7).
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "diagnosis/estimation/session.hpp"
#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/validation/remainder.hpp"

namespace gustlab::diagnosis {

// Moves names from the effects of `out` to its rejected ones, but those that stand.
void suspect(Diagnosis& out, const std::string& why, const std::function<bool(const EffectFinding&)>& stands = [](const EffectFinding&) { return false; });

// Names that may be shadows are only suspected. `recovered`: share of the recoverable held-out error; `at_bound`: what ran into its
// bound; `pose_late_s`: how late gyro and attitudes by themselves say that the pose is, nothing where
// they are not recorded.
void withdraw_shadows(const Session& session, const Selection& selection, const Remainder& rest, double recovered, const std::string& at_bound,
                      const std::function<std::optional<double>()>& pose_late_s, Diagnosis& out);

}  // namespace gustlab::diagnosis
