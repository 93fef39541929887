// Which controller is best where, and when does each break: the variants of a sweep side by side.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "metrics/statistics.hpp"
#include "sweep/results.hpp"

namespace gustlab {

// A controller in one variant. Errors are planar root mean squares in m, over the runs that it completed. A run is held when it
// was completed with an error up to the limit.
struct ComparedController {
  std::string name;
  std::size_t completed = 0, held = 0, total = 0;
  Interval held_share{};                                 // 95 %, Wilson
  double rmse_m = 0.0;                                   // NaN when no run was completed
  double rotor_sd_radps = 0.0, rotor_rate_radps2 = 0.0;  // mean effort over the same runs
  double behind_m = 0.0;  // mean of its error less the best one's, in the runs that both completed
  Interval behind{};      // 95 %, paired bootstrap over these runs
  bool broken = false;    // fewer than 95 % held
  // the best itself, or not told from it: the interval holds zero; never without a run held
  bool as_good_as_best = false;
};
struct ComparedVariant {
  std::string name;
  std::size_t best = 0;  // the least error of those that held 95 %; where nobody did, whoever held most
  std::vector<ComparedController> controllers;
  NamedValue alone{};     // the axis that it alone moves along
  double settle_s = 0.0;  // the same in all
};

struct NamedResults {
  std::string name;
  Results results;
  NamedValue alone{};
};
// Every controller flew every variant in the same gusts. A gust is a replicate: intervals resample gusts with all trajectories
// that met them. Throws DataError when the runs differ, or the time from which samples count.
std::vector<ComparedVariant> compare(std::span<const NamedResults> variants, double limit_m);

// How far a controller goes along an axis whose points were flown alone, in the order of the file: the last value before the first at
// which it is broken. The values are as the file writes them.
struct Margin {
  std::string axis;
  std::vector<std::string> values;  // flown
  std::vector<std::size_t> held;    // of each controller, how many of them
};
std::vector<Margin> margins_of(std::span<const ComparedVariant> variants);

std::string to_markdown(std::span<const ComparedVariant> variants, double limit_m);
std::string to_json(std::span<const ComparedVariant> variants, double limit_m);

}  // namespace gustlab
