// Least squares in few unknowns, for problems that sum their normal equations themselves (Marquardt, J. SIAM 11, 1963).
#pragma once

#include <Eigen/Cholesky>
#include <cmath>

namespace gustlab::diagnosis {

struct Marquardt {
  double damping = 1e-3;  // to begin with, relative to the diagonal
  double harder = 10.0;   // after a step that is no better (0.2 after one that is)
  double settled = 1e-5;  // relative fall of the cost below which it is enough
  int most_steps = 25, most_attempts = 8;
};

template <class Matrix, class Vector>
struct NormalEquations {
  Matrix normal;  // JᵀJ
  Vector right;   // −Jᵀr: solves to the step of Gauss and Newton
};

// Moves `at` to a lower cost and returns the cost there. `cost`: at the start, finite. `linearise(at)` gives the normal equations, `cost_at(at)` the
// cost; `last` are the normal equations of the last step.
template <class Matrix, class Vector, class Linearise, class Cost>
double minimise(Vector& at, double cost, const Marquardt& how, const Linearise& linearise, const Cost& cost_at,
                NormalEquations<Matrix, Vector>& last) {
  double damping = how.damping;
  for (int step = 0; step < how.most_steps; ++step) {
    last = linearise(at);
    bool better = false, settled = false;
    for (int attempt = 0; attempt < how.most_attempts && !better; ++attempt) {
      Matrix damped = last.normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12 * last.normal.diagonal().maxCoeff();
      const Vector trial = at + damped.ldlt().solve(last.right);
      const double least = cost_at(trial);
      better = std::isfinite(least) && least < cost;
      damping *= better ? 0.2 : how.harder;
      if (!better) continue;
      settled = least > cost * (1.0 - how.settled);
      at = trial;
      cost = least;
    }
    if (!better || settled) break;
  }
  return cost;
}

}  // namespace gustlab::diagnosis
