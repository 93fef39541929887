#include <limits>
#include <string>

#include "gustlab/errors.hpp"
#include "identification/optimizer.hpp"
#include "util/interrupt.hpp"

namespace gustlab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_terms = 16;
// a column whose new direction is shorter than this share of it adds nothing but rounding
constexpr double dependent = 1e-13;

// Visits every support once, depth first: each step adds one column, orthogonalised against those before it, and takes
// its direction out of the residuals of all targets.
struct Search {
  const MatrixXd theta;      // R_ΘΘ
  const VectorXd unreached;  // per target, the squared residual that no term can take
  const double price;
  const Index most_active;
  MatrixXd basis;  // orthonormal directions of the support
  std::vector<Index> support{};
  VectorXd best_objective;
  std::vector<std::vector<Index>> best_support;
  int visited = 0;

  void visit(Index next, const MatrixXd& residual) {
    throw_if_interrupted();
    const Index size = static_cast<Index>(support.size());
    ++visited;
    for (Index t = 0; t < residual.cols(); ++t) {
      const double objective = 0.5 * (unreached[t] + residual.col(t).squaredNorm()) + price * static_cast<double>(size);
      if (objective < best_objective[t]) {
        best_objective[t] = objective;
        best_support[static_cast<std::size_t>(t)] = support;
      }
    }
    if (size == most_active) return;
    for (Index j = next; j < theta.cols(); ++j) {
      // twice, so that rounding leaves the direction orthogonal
      VectorXd direction = theta.col(j);
      for (int pass = 0; pass < 2; ++pass) {
        direction -= basis.leftCols(size) * (basis.leftCols(size).transpose() * direction);
      }
      const double length = direction.norm();
      if (length <= dependent * theta.col(j).norm()) continue;
      basis.col(size) = direction / length;
      support.push_back(j);
      visit(j + 1, residual - basis.col(size) * (basis.col(size).transpose() * residual));
      support.pop_back();
    }
  }
};

}  // namespace

Fit best_subset(const RegressionData& data, const OptimizerOptions& options) {
  const Index terms = data.terms(), targets = data.targets();
  if (terms > most_terms) {
    throw ConfigError("best_subset: " + std::to_string(terms) + " terms (every support is tried, so at most 16); " +
                      "use a smaller library, or sr3");
  }
  Search search{.theta = data.theta_factor(),
                .unreached = data.unreached(),
                .price = options.lambda,
                .most_active = options.max_terms > 0 ? options.max_terms : terms,
                .basis = MatrixXd(terms, terms),
                .best_objective = VectorXd::Constant(targets, std::numeric_limits<double>::infinity()),
                .best_support = std::vector<std::vector<Index>>(static_cast<std::size_t>(targets))};
  search.visit(0, data.target_factor());

  Fit out;
  out.iterations = search.visited;
  out.coefficients = MatrixXd::Zero(targets, terms);
  for (Index t = 0; t < targets; ++t) {
    const std::vector<Index>& support = search.best_support[static_cast<std::size_t>(t)];
    const VectorXd solution = data.solve(support, t);
    for (std::size_t i = 0; i < support.size(); ++i) out.coefficients(t, support[i]) = solution[static_cast<Index>(i)];
  }
  out.full = out.coefficients;
  return out;
}

}  // namespace gustlab
