#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/evidence/gather_evidence.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "gustlab/errors.hpp"

namespace gustlab::diagnosis {

namespace {

// of paired errors (without, with): share that the effect removes, and their difference over its standard error
struct Removed {
  double share = 0.0, z = 0.0;
  bool is_known = false;  // such a quantity was recorded
};

struct Pairs {
  double without = 0.0, difference = 0.0, squares = 0.0, count = 0.0;
  void add(double error_without, double error_with) {
    if (!std::isfinite(error_without) || !std::isfinite(error_with)) return;
    const double d = error_without - error_with;
    without += error_without, difference += d, squares += d * d, count += 1.0;
  }
  Removed removed() const {
    if (count < 8.0 || !(without > 0.0)) return {};
    const double mean = difference / count, variance = std::max(0.0, squares / count - mean * mean);
    return {difference / without, mean / std::sqrt(variance / (count - 1.0) + 1e-30), true};
  }
};

using PairsOfHorizon = std::array<Pairs, 4>;  // one per quantity

// of two quantities, those that were recorded
Removed mean_of(const PairsOfHorizon& quantities, std::size_t first) {
  Removed sum;
  double seen = 0.0;
  for (std::size_t q = first; q < first + 2; ++q)
    if (quantities[q].count > 0.0)
      sum.share += quantities[q].removed().share, sum.z += quantities[q].removed().z, seen += 1.0;
  return Removed{sum.share / std::max(seen, 1.0), sum.z / std::max(seen, 1.0), seen > 0.0};
}

}  // namespace

std::vector<Recording> recordings_to_fly(const std::vector<FlightLog>& logs, const VehicleModel& vehicle) {
  std::vector<Recording> recordings;
  for (const FlightLog& log : logs) {
    try {
      recordings.emplace_back(log, vehicle, ReplayOptions{});
    } catch (const DataError&) {
      // without attitude: said under not_identifiable
    }
  }
  return recordings;
}

namespace {

// Moments that nobody knows turn a body, and it is then pushed the wrong way. Along the attitude as it was recorded forces are judged by
// themselves, where they do something and the effect does not turn the body wrongly.
Removed best_of(const PairsOfHorizon& freely, const PairsOfHorizon& led) {
  constexpr double does_something = 0.01, turns_wrongly = -0.05, surely = -2.0, goes_far_wrong = -0.7;
  const Removed moves = mean_of(freely, 0), turns = mean_of(freely, 2), led_moves = mean_of(led, 0);
  // the arm of a centre of mass moves a body whose attitude is given a little: only what goes far wrong speaks there
  if (!turns.is_known && moves.z < 0.0 && moves.share > goes_far_wrong) return {};
  const Removed best = !turns.is_known || (moves.is_known && moves.z >= turns.z) ? moves : turns;
  const bool counts = std::abs(led_moves.share) >= does_something && !(turns.share < turns_wrongly && turns.z < surely);
  return counts && led_moves.z > best.z ? led_moves : best;
}

// Errors without each finding and with all, by finding and horizon.
std::vector<std::vector<PairsOfHorizon>> fly(const std::vector<Recording>& held_out, const std::vector<EffectSpec>& own,
                                             const std::vector<EffectSpec>& found, const ReplayOptions& options,
                                             bool& flown) {
  const std::vector<EffectSpec> all = config::merge_effects(own, found);
  const std::size_t horizons = options.horizon_s.size();
  std::vector<std::vector<PairsOfHorizon>> pairs(found.size(), std::vector<PairsOfHorizon>(horizons));
  for (const Recording& recording : held_out) {
    try {
      const FitErrors with = replay(recording, all, options);
      flown = true;
      for (std::size_t i = 0; i < found.size(); ++i) {
        std::vector<EffectSpec> rest = found;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
        const FitErrors without = replay(recording, config::merge_effects(own, rest), options);
        for (const auto& [a, b] : common_windows(with, without))
          for (std::size_t h = 0; h < horizons; ++h)
            for (std::size_t q = 0; q < 4; ++q)
              pairs[i][h][q].add(without.quantities[q].model[b * horizons + h],
                                 with.quantities[q].model[a * horizons + h]);
      }
    } catch (const DataError&) {
      // without a stretch of a second: said under not_identifiable
    }
  }
  return pairs;
}

}  // namespace

void fly_without_each(const std::vector<Recording>& held_out, const std::vector<EffectSpec>& own,
                      const std::vector<EffectSpec>& found, int jobs, std::vector<Evidence>& records) {
  ReplayOptions options;
  options.jobs = jobs;
  options.with_noise = false;
  bool flown = false;
  const auto freely = fly(held_out, own, found, options, flown);
  if (!flown) return;
  auto led = freely;
  if (!std::ranges::all_of(held_out, &Recording::collective_only)) {
    std::vector<Recording> along = held_out;
    for (Recording& recording : along) recording.collective_only = true;
    led = fly(along, own, found, options, flown);
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].horizon_s = options.horizon_s;
    for (std::size_t h = 0; h < options.horizon_s.size(); ++h) {
      const Removed removed = best_of(freely[i][h], led[i][h]);
      records[i].recovered.push_back(removed.share);
      records[i].recovered_z.push_back(removed.z);
    }
  }
}

}  // namespace gustlab::diagnosis
