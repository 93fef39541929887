// Which controller is best where, and when does each break: the variants of a sweep side by side.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "metrics/statistics.hpp"
#include "sweep/results.hpp"

namespace gustlab {

// A controller in one variant. Errors are planar root mean squares in m, over the runs that it completed.
struct ComparedController {
  std::string name;
  std::size_t completed = 0, total = 0;
  Interval completion{};          // 95 %, Wilson
  double rmse_m = 0.0;            // NaN when no run was completed
  double behind_m = 0.0;          // mean of its error less the best one's, in the runs that both completed
  Interval behind{};              // 95 %, paired bootstrap over these runs
  bool broken = false;            // fewer than 95 % completed, or twice its own error in the first variant
  bool as_good_as_best = false;   // the best itself, or not told from it: the interval holds zero
};
struct ComparedVariant {
  std::string name;
  std::size_t best = 0;  // the least error of those that completed 95 %; where nobody did, whoever completed most
  std::vector<ComparedController> controllers;
};

struct NamedResults {
  std::string name;
  Results results;
};
// Every controller flew every variant in the same gusts; the first variant is what the others differ from. Throws DataError
// when the runs differ.
std::vector<ComparedVariant> compare(std::span<const NamedResults> variants);

std::string to_markdown(std::span<const ComparedVariant> variants);
std::string to_json(std::span<const ComparedVariant> variants);

}  // namespace gustlab
