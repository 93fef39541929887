// A sweep on one page that needs nothing but a browser: table, heat maps and errors over its axes, paths, and what failed.
#pragma once

#include <string>
#include <vector>

#include "sweep/results.hpp"

namespace gustlab {

// A path that was flown, and what it should have been.
struct SweptPath {
  std::string trajectory, controller;
  std::vector<double> x_m, y_m, reference_x_m, reference_y_m;
};

struct SweepFigures {
  std::vector<SweptPath> paths;  // one of each trajectory and controller, of the same gust
  std::string paths_of;          // which runs these are; empty: no log is there
};

// Precondition: results have a row.
std::string sweep_page(const Results& results, const SweepFigures& figures);

}  // namespace gustlab
