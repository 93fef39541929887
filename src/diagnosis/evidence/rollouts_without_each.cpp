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
    return {difference / without, mean / std::sqrt(variance / (count - 1.0) + 1e-30)};
  }
};

// the better of what forces move and what moments turn, each the mean of its two quantities
Removed better_of(const std::array<Pairs, 4>& quantities) {
  const auto mean = [&](std::size_t first) {
    Removed sum;
    double seen = 0.0;
    for (std::size_t q = first; q < first + 2; ++q)
      if (quantities[q].count > 0.0)
        sum.share += quantities[q].removed().share, sum.z += quantities[q].removed().z, seen += 1.0;
    return Removed{sum.share / std::max(seen, 1.0), sum.z / std::max(seen, 1.0)};
  };
  const Removed moves = mean(0), turns = mean(2);
  return moves.z >= turns.z ? moves : turns;
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

void fly_without_each(const std::vector<Recording>& held_out, const std::vector<EffectSpec>& own,
                      const std::vector<EffectSpec>& found, int jobs, std::vector<Evidence>& records) {
  ReplayOptions options;
  options.jobs = jobs;
  options.with_noise = false;
  const std::vector<EffectSpec> all = config::merge_effects(own, found);
  std::vector<std::vector<std::array<Pairs, 4>>> pairs(found.size(),
                                                       std::vector<std::array<Pairs, 4>>(options.horizon_s.size()));
  bool flown = false;
  for (const Recording& recording : held_out) {
    try {
      const FitErrors with = replay(recording, all, options);
      flown = true;
      for (std::size_t i = 0; i < found.size(); ++i) {
        std::vector<EffectSpec> rest = found;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
        const FitErrors without = replay(recording, config::merge_effects(own, rest), options);
        // a late pose starts its windows later: only windows of both count
        for (std::size_t a = 0, b = 0; a < with.windows() && b < without.windows();) {
          if (with.start_row[a] != without.start_row[b]) {
            with.start_row[a] < without.start_row[b] ? ++a : ++b;
            continue;
          }
          for (std::size_t h = 0; h < options.horizon_s.size(); ++h)
            for (std::size_t q = 0; q < 4; ++q)
              pairs[i][h][q].add(without.quantities[q].model[b * options.horizon_s.size() + h],
                                 with.quantities[q].model[a * options.horizon_s.size() + h]);
          ++a, ++b;
        }
      }
    } catch (const DataError&) {
      // without a stretch of a second: said under not_identifiable
    }
  }
  if (!flown) return;
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].horizon_s = options.horizon_s;
    for (std::size_t h = 0; h < options.horizon_s.size(); ++h) {
      const Removed removed = better_of(pairs[i][h]);
      records[i].recovered.push_back(removed.share);
      records[i].recovered_z.push_back(removed.z);
    }
  }
}

}  // namespace gustlab::diagnosis
