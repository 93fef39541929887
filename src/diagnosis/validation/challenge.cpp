#include "diagnosis/validation/challenge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/selection/select_effects.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr int most_rounds = 6;
constexpr double least_tested = 10.0;   // χ² that a finding should save on the held-out flights
// feedback of sensors that were not logged makes rotors seem weaker or later than they are: χ² over that of unforetold commands
constexpr double least_over_unforetold = 2.0;
constexpr double most_spread = 0.15;    // between regimes, as a share of the whole
constexpr double surely_uneven = 18.0;  // χ² of two degrees of freedom: p = 0.001 over nine variables

// what the held-out flights do not excite, they do not refute
bool does_not_pay(const HoldoutTest& tested, std::size_t i) {
  return tested.rows > 0.0 && tested.gain[i] <= 0.0 && tested.expected[i] >= least_tested;
}

// An effect that only commands can show may be feigned by what the log does not hold of them, unless one that shows without
// them explains about the same.
bool feigned_by_commands(const Session& session, const Selection& selection, const Finding& finding) {
  const auto commanded = [&](int group) { return session.catalogue().groups()[static_cast<std::size_t>(group)].row->commanded; };
  if (!commanded(finding.group) || finding.gain >= least_over_unforetold * selection.unforetold_gain) return false;
  return std::none_of(finding.rivals.begin(), finding.rivals.end(), [&](const Rival& rival) {
    return !commanded(rival.group) && !rival.below_tolerance && rival.delta_score < 0.5 * finding.gain;
  });
}

const Regimes* uneven(const std::vector<Regimes>& regimes) {
  for (const Regimes& r : regimes)
    if (r.spread > most_spread && r.chi_squared > surely_uneven) return &r;
  return nullptr;
}

}  // namespace

Challenge challenge(Session& session, Selection& selection, const std::vector<FlightData>& held,
                    const std::vector<FlightData>& held_own_rate, double least_included, int jobs) {
  Challenge result;
  for (int round = 0;; ++round) {
    result.tested = test_holdout(session, selection, held, held_own_rate, jobs);
    result.regimes = regimes(session, selection);
    std::vector<int> failed;
    std::size_t widest = 0;
    double spread = 0.0;
    const auto withdraw_finding = [&](std::size_t i, double gain, std::string why) {
      const Group& group = session.catalogue().groups()[static_cast<std::size_t>(selection.findings[i].group)];
      result.withdrawn.push_back({std::string(group.row->name), gain, std::move(why)});
      failed.push_back(selection.findings[i].group);
    };
    for (std::size_t i = 0; i < selection.findings.size(); ++i) {
      if (selection.findings[i].calibration) continue;
      const Group& group = session.catalogue().groups()[static_cast<std::size_t>(selection.findings[i].group)];
      if (does_not_pay(result.tested, i))
        withdraw_finding(i, result.tested.gain[i], "fits the flights it was found on, and does not pay on the held-out ones");
      else if (selection.findings[i].inclusion < least_included)
        withdraw_finding(i, result.tested.gain[i], "only suspected: not every part of the flights says so, and there is no pose to verify it on");
      else if (feigned_by_commands(session, selection, selection.findings[i]))
        withdraw_finding(i, selection.findings[i].gain, "only suspected: the commands tell more of what the log does not hold than this explains");
      // values of every flight's own catch whatever has a mean
      const Regimes* r = group.row->per_flight ? uneven(result.regimes[i]) : nullptr;
      if (r && r->spread > spread) spread = r->spread, widest = i;
    }
    // one at a time: what goes may be what made the others uneven
    if (failed.empty() && spread > 0.0) {
      const Regimes& r = *uneven(result.regimes[widest]);
      result.uneven = true;
      withdraw_finding(widest, selection.findings[widest].gain,
                       fmt::format("only suspected: it is {:.0f}, {:.0f} and {:.0f} % of itself where {} is low, middling and high; physics "
                                   "would be the same everywhere",
                                   100.0 * r.share[0], 100.0 * r.share[1], 100.0 * r.share[2], r.variable));
    }
    if (failed.empty()) {
      const std::vector<Parts> pushes = parts(session, selection);
      const auto uneven_parts = [&](std::size_t i) { return !selection.findings[i].calibration && pushes[i].uneven(); };
      std::size_t worst = pushes.size();
      for (std::size_t i = 0; i < pushes.size(); ++i)
        if (uneven_parts(i) && (worst == pushes.size() || std::abs(pushes[i].excess) > std::abs(pushes[worst].excess))) worst = i;
      if (worst < pushes.size())
        withdraw_finding(worst, selection.findings[worst].gain,
                         fmt::format("only suspected: it pushes {:.0f} ± {:.0f} % of what its turning foretells", 100.0 * (1.0 + pushes[worst].excess),
                                     100.0 * pushes[worst].deviation));
    }
    if (failed.empty() || round == most_rounds) return result;
    selection = withdraw(session, {}, selection, failed);
  }
}

}  // namespace gustlab::diagnosis
