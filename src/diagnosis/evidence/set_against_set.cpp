#include "diagnosis/evidence/set_against_set.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "config/toml.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "diagnosis/selection/alternatives.hpp"
#include "diagnosis/selection/found_effects.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "gustlab/errors.hpp"

namespace gustlab::diagnosis {

namespace {

struct Sum {
  double sum = 0.0, count = 0.0;
};

// Logarithm of the ratio of errors, of every window and quantity that one of the models at least predicts better than a body that stays as it
// was: the errors of two that are lost are chance.
void add_ratios(const FitErrors& some, const FitErrors& others, std::map<std::size_t, Sum>& by_row) {
  for (const auto& [a, b] : common_windows(some, others))
    for (std::size_t q = 0; q < some.quantities.size(); ++q) {
      const double error = some.quantities[q].model[a], other = others.quantities[q].model[b],
                   ratio = std::log(error / other);
      if (std::isfinite(ratio) && std::min(error, other) < some.quantities[q].hold[a])
        by_row[some.start_row[a]].sum += ratio, by_row[some.start_row[a]].count += 1.0;
    }
}

}  // namespace

double log_ratio_z(const std::vector<Recording>& held_out, const std::vector<EffectSpec>& own,
                   const std::vector<EffectSpec>& some, const std::vector<EffectSpec>& others, int jobs) {
  ReplayOptions options;
  options.horizon_s = {0.5};
  options.with_noise = false;
  options.jobs = jobs;
  const std::vector<EffectSpec> all_some = config::merge_effects(own, some),
                                all_others = config::merge_effects(own, others);
  std::vector<double> windows;
  for (const Recording& recording : held_out) {
    std::map<std::size_t, Sum> by_row;
    try {
      add_ratios(replay(recording, all_some, options), replay(recording, all_others, options), by_row);
      if (!recording.collective_only) {
        Recording led = recording;
        led.collective_only = true;
        add_ratios(replay(led, all_some, options), replay(led, all_others, options), by_row);
      }
    } catch (const DataError&) {
      // without a stretch of half a second: said under not_identifiable
    }
    for (const auto& [row, window] : by_row) windows.push_back(window.sum / window.count);
  }
  if (windows.size() < decisions::least_windows) return 0.0;
  const Eigen::Map<const Eigen::VectorXd> ratio(windows.data(), std::ssize(windows));
  const double mean = ratio.mean(), count = static_cast<double>(windows.size());
  const double variance = (ratio.array() - mean).square().sum() / (count - 1.0);
  return mean / std::sqrt(variance / count + 1e-30);
}

std::optional<Selection> flies_better(Session& session, const Selection& standing,
                                      const std::vector<Recording>& held_out, const std::set<int>& left_out,
                                      std::set<std::vector<int>>& tried) {
  if (held_out.empty()) return std::nullopt;
  const std::vector<EffectSpec>& own = session.vehicle().effects;
  const std::vector<EffectSpec> found = effects_found(session.catalogue(), standing);
  const Session::Learned learned = session.learned();
  const Eigen::VectorXd linearised_at = session.value();
  struct Better {
    Selection selection;
    Session::Learned learned;
    Eigen::VectorXd linearised_at;
  };
  std::optional<Better> best;
  double least = -decisions::surely_flies_better;
  bool fitted = false;
  tried.insert(standing.groups());
  for (const std::vector<int>& groups : alternatives(session, standing, left_out)) {
    if (!tried.insert(groups).second) continue;
    fitted = true;
    session.put_back(learned);
    Selection other = select_given(session, standing, groups, left_out);
    const double z = log_ratio_z(held_out, own, effects_found(session.catalogue(), other), found, session.jobs());
    if (z > least) continue;
    least = z;
    best = Better{std::move(other), session.learned(), session.value()};
  }
  if (!fitted) return std::nullopt;
  session.put_back(best ? std::move(best->learned) : learned);
  session.linearise(best ? best->linearised_at : linearised_at, session.all_columns());
  if (!best) return std::nullopt;
  return std::move(best->selection);
}

}  // namespace gustlab::diagnosis
