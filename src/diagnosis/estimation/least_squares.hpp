// Nonlinear least squares in few unknowns: how Ceres is asked, so that the answer has the same bytes on any number of threads.
#pragma once

#include <ceres/solver.h>

namespace gustlab::diagnosis {

struct FewUnknowns {
  double damping = 1e-3;  // of Levenberg and Marquardt to begin with, relative to the diagonal of JᵀJ
  double settled = 1e-5;  // relative fall of the cost below which it is enough
  int most_steps = 50;    // with those that were refused
};

// Levenberg–Marquardt by dense normal equations, on one thread and silent. A step to where a cost function returns false is refused.
inline ceres::Solver::Options few_unknowns(const FewUnknowns& how) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1.0 / how.damping;
  options.function_tolerance = how.settled;
  options.max_num_iterations = how.most_steps;
  options.max_num_consecutive_invalid_steps = how.most_steps;
  return options;
}

}  // namespace gustlab::diagnosis
