// A gate for continuous integration: results against a baseline, run by run, each with the seed that it met.
#pragma once

#include <string>
#include <vector>

#include "sweep/results.hpp"

namespace gustlab {

// A run fails when an error exceeds its baseline by more than both.
struct GateTolerance {
  double absolute_m = 0.005;
  double relative = 0.05;
};

struct GateCase {
  std::string cell;      // vehicle trajectory controller
  std::int64_t replicate;
  std::string failure;   // empty: passed
};

struct GateReport {
  std::vector<GateCase> cases;     // baseline order, extra rows last
  std::string changes;             // Markdown: mean paired difference of each cell
  std::size_t failures() const;
};

// A run that was completed and no longer is, a run that is missing, and a run that the baseline does not know fail,
// whatever the tolerance. Being better never fails.
GateReport gate(const std::vector<ResultRow>& now, const std::vector<ResultRow>& baseline, const GateTolerance& tolerance);

std::string to_junit(const GateReport& report);
std::string to_markdown(const GateReport& report);

}  // namespace gustlab
