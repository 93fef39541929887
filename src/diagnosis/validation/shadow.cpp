#include "diagnosis/validation/shadow.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gustlab::diagnosis {

namespace {

// beyond these a finding is only suspected
constexpr double least_recovered = 0.5;
constexpr double most_unexplained = 0.12;    // unless clearly most of the held-out error is recovered
constexpr double clearly_recovered = 0.75;
// a name is no shadow when it is of one size everywhere (to this share of it), explains more than anything that is left
// could, and with the others half of the variance of one disturbance (what smoothing left of it says nothing)
constexpr double surely_even = 0.3, clearly_more = 2.0, half_gone = 0.7;
// of a delay, that sensors tell without any force
constexpr double least_told = 0.5;

// of the four disturbances, how much the findings leave of the one that they explain best; all, when one is left that is as large as before
double least_disturbance_left(const Selection& selection, const std::array<double, disturbance_groups>& floor) {
  double least = 1.0;
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    const double left = selection.noise_selected.rms(g) / selection.noise_nominal.rms(g);
    if (selection.noise_selected.rms(g) > most_of_floor * floor[g] && left > half_gone) return 1.0;
    least = std::min(least, left);
  }
  return least;
}

}  // namespace

void suspect(Diagnosis& out, const std::string& why, const std::function<bool(const EffectFinding&)>& stands) {
  std::erase_if(out.effects, [&](const EffectFinding& effect) {
    if (stands(effect)) return false;
    out.rejected.push_back({effect.effect, effect.gain, why});
    return true;
  });
}

void withdraw_shadows(const Session& session, const Selection& selection, const Remainder& rest, double recovered, const std::string& at_bound,
                      const std::function<std::optional<double>()>& pose_late_s, Diagnosis& out) {
  const bool doubted = !rest.alarms.empty() && (recovered < least_recovered || (rest.omnibus_share > most_unexplained && recovered < clearly_recovered));
  if (!doubted && at_bound.empty()) return;
  suspect(out, fmt::format("only suspected: {:.0f} % of the structure is not explained, {:.0f} % of the held-out error is recovered",
                           100.0 * rest.omnibus_share, 100.0 * recovered),
          [&](const EffectFinding& effect) {
            if (!at_bound.empty()) return false;
            // measured speeds drive the rollouts, and show by themselves how commands come to them
            if (session.seen_in_speeds(session.catalogue().find(effect.effect))) return true;
            // how late a pose is gyro and attitudes tell, whatever the forces are
            if (effect.effect == "pose_delay")
              if (const std::optional<double> told_s = pose_late_s()) return *told_s > least_told * effect.parameters.front().value;
            return effect.astray < surely_even && effect.gain > clearly_more * rest.omnibus_gain &&
                   (session.shoots() || least_disturbance_left(selection, reference_floor(session.vehicle())) < half_gone);
          });
}

}  // namespace gustlab::diagnosis
