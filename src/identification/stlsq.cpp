#include <algorithm>
#include <cmath>

#include "identification/optimizer.hpp"

namespace gustlab {

Fit stlsq(const RegressionData& data, const OptimizerOptions& options) {
  Fit out;
  out.coefficients = Eigen::MatrixXd::Zero(data.targets(), data.terms());
  for (Eigen::Index t = 0; t < data.targets(); ++t) {
    std::vector<Eigen::Index> support;
    for (Eigen::Index j = 0; j < data.terms(); ++j) support.push_back(j);
    // fit, drop what is below the threshold, until nothing drops
    for (int iteration = 1;; ++iteration) {
      const Eigen::VectorXd solution = data.solve(support, t, options.ridge);
      out.coefficients.row(t).setZero();
      std::vector<Eigen::Index> large;
      for (std::size_t i = 0; i < support.size(); ++i) {
        const double value = solution[static_cast<Eigen::Index>(i)];
        if (std::abs(value) < options.lambda) continue;
        large.push_back(support[i]);
        out.coefficients(t, support[i]) = value;
      }
      out.iterations = std::max(out.iterations, iteration);
      if (large.size() == support.size()) break;
      support = std::move(large);
      if (iteration == options.max_iterations) {
        out.converged = false;
        break;
      }
    }
  }
  out.full = out.coefficients;
  return out;
}

}  // namespace gustlab
