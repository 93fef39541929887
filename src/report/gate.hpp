// A gate for continuous integration: results against a baseline, cell by cell, in pairs that met the same gust.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "report/tables.hpp"
#include "sweep/results.hpp"

namespace gustlab {

// When a cell fails. Either switch may be off.
struct GateRule {
  bool by_margin = true;     // its mean error rose by more than the margin
  bool by_test = true;       // its mean error rose significantly, however little
  double margin = 0.02;      // share of the baseline's mean error
  double level = 0.01;       // of all tests of the gate together (Holm)
  double floor_m = 1e-5;     // a mean that rose by less never fails: rounding differs between machines
  bool allow_extra = false;  // runs that the baseline does not have are left out
};

// A metric of a cell: both means, and the paired change.
struct GateChange {
  double before_m, now_m, change_m;
  Interval interval_m;       // 90 %, Student's: inside the margin both ways, the cell is equivalent at 5 %
  double p_worse, p_better;  // one-sided, paired t; NaN when there are fewer than two pairs
};

struct GateCell {
  std::string experiment, cell;  // cell: vehicle trajectory controller
  std::size_t pairs = 0;
  std::array<GateChange, tracking_metrics.size()> changes{};
  bool configuration_changed = false;   // keys of the runs differ
  std::vector<std::string> failures{};  // empty: passed
  std::size_t unpaired = 0;             // of the failures: runs that only one of the two has
  // worse, other runs, not compared, improved, equivalent, cannot tell; of the planar RMSE unless a metric failed
  std::string verdict{};
};

struct GateReport {
  GateRule rule;
  std::size_t runs = 0;          // of the baseline
  std::vector<GateCell> cells;   // baseline order, extra ones last
  std::size_t failures() const;  // cells that failed
};

// A run that was completed and no longer is, a run that is missing, an error that is no longer a number, and (unless allowed) a
// run that the baseline does not know fail, whatever the rule; where no cell has an error to compare, all of them do. Being better
// never fails. Throws DataError when the baseline is of other experiments.
GateReport gate(const std::vector<ResultRow>& now, const std::vector<ResultRow>& baseline, const GateRule& rule);

std::string to_junit(const GateReport& report);
// The summary first; of long lists the beginning.
std::string to_markdown(const GateReport& report);

}  // namespace gustlab
