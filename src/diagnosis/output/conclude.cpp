#include "diagnosis/output/conclude.hpp"

#include <algorithm>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

Verdict conclude(const Diagnosis& out, const Remainder& rest, bool at_bound, bool commands_jitter) {
  if (commands_jitter && out.effects.empty()) return Verdict::insufficient_data;
  const bool quiet =
      std::all_of(rest.alarms.begin(), rest.alarms.end(), [](const Alarm& a) { return a.kind == "omnibus"; });
  const bool little = quiet && rest.omnibus_share < decisions::explained_share;
  if (!out.effects.empty()) return little ? Verdict::explained : Verdict::partly_explained;
  // long logs show what is less than a calibration that itself is too small to be reported
  const bool less = little && !out.calibration.empty() && out.suspected.empty();
  return (rest.alarms.empty() || less) && !at_bound ? Verdict::consistent : Verdict::unexplained;
}

}  // namespace gustlab::diagnosis
