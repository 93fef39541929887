#include "identification/optimizer.hpp"

#include <Eigen/QR>
#include <cmath>
#include <string>

#include "gustlab/errors.hpp"
#include "util/interrupt.hpp"

namespace gustlab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double largest_coefficient(const RegressionData& data) { return data.least_squares().cwiseAbs().maxCoeff(); }

// thresholds from the largest least-squares coefficient over five decades
std::vector<double> threshold_path(const RegressionData& data, const OptimizerOptions&) {
  return geometric_path(largest_coefficient(data), std::pow(10.0, -0.125), 41);
}

std::vector<double> sr3_path(const RegressionData& data, const OptimizerOptions& options) {
  if (options.penalty == Regularizer::l2) return geometric_path(1e2 / options.nu, std::pow(10.0, -0.25), 33);
  std::vector<double> path = threshold_path(data, options);
  // the λ at which the proximal step has that threshold
  for (double& value : path) {
    value = options.penalty == Regularizer::l0 ? value * value / (2.0 * options.nu) : value / options.nu;
  }
  return path;
}

std::vector<double> best_subset_path(const RegressionData& data, const OptimizerOptions&) {
  const double half_power = 0.5 * data.squared_error(MatrixXd::Zero(data.targets(), data.terms())).maxCoeff();
  return geometric_path(half_power, std::pow(10.0, -0.25), 57);
}

constexpr OptimizerRow optimizers[] = {
    {.name = "stlsq",
     .says = "sequentially thresholded least squares: drop small coefficients, fit again, until none is small",
     .takes_constraints = false,
     .takes_penalty = false,
     .refits_by_default = true,
     .run = stlsq,
     .lambda_path = threshold_path},
    {.name = "sr3",
     .says = "sparse relaxed regularized regression with an L0, L1 or L2 penalty and linear constraints",
     .takes_constraints = true,
     .takes_penalty = true,
     .refits_by_default = false,
     .run = sr3,
     .lambda_path = sr3_path},
    {.name = "best_subset",
     .says = "every support is tried: the exact minimum for a price per term, up to 16 terms",
     .takes_constraints = false,
     .takes_penalty = false,
     .refits_by_default = false,
     .run = best_subset,
     .lambda_path = best_subset_path},
};

VectorXd column_scale(const RegressionData& data, const OptimizerOptions& options) {
  return options.normalize_columns ? VectorXd(data.column_norms().cwiseInverse()) : VectorXd::Ones(data.terms());
}

// columns of C for coefficients of scaled columns: w = scale · w_scaled
LinearConstraints scaled(const LinearConstraints& constraints, const VectorXd& scale, Index targets) {
  LinearConstraints out = constraints;
  if (!out.empty()) out.C *= scale.replicate(targets, 1).asDiagonal();
  return out;
}

[[noreturn]] void fail_infeasible() {
  throw ConfigError("the constraints cannot hold on the terms that were found; use a smaller lambda");
}

// the terms that were found; where a constraint asks for something other than zero, those in constraints too
Support refit_support(const MatrixXd& coefficients, const LinearConstraints& constraints) {
  Support support = coefficients.array() != 0.0;
  if (constraints.empty() || constraints.d.isZero(0.0)) return support;
  for (Index i = 0; i < constraints.C.cols(); ++i) {
    if (!constraints.C.col(i).isZero(0.0)) support(i / support.cols(), i % support.cols()) = true;
  }
  return support;
}

void check(const OptimizerRow& optimizer, const RegressionData& data, const OptimizerOptions& options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  // before lambda, which may have been searched for with it
  if (!positive(options.nu)) throw ConfigError("nu must be finite and above 0");
  if (!(options.lambda >= 0.0) || !std::isfinite(options.lambda))
    throw ConfigError("lambda must be finite and at least 0");
  if (!(options.ridge >= 0.0) || !std::isfinite(options.ridge))
    throw ConfigError("ridge must be finite and at least 0");
  if (!positive(options.tolerance)) throw ConfigError("tolerance must be finite and above 0");
  if (options.max_iterations < 1) throw ConfigError("max_iterations must be at least 1");
  if (options.constraints.empty()) return;
  if (!optimizer.takes_constraints) {
    throw ConfigError("optimizer " + std::string(optimizer.name) + " takes no constraints; use sr3");
  }
  const LinearConstraints& c = options.constraints;
  if (c.C.cols() != data.terms() * data.targets() || c.C.rows() != c.d.size()) {
    throw ConfigError("constraints do not match the terms and targets");
  }
  if (Eigen::ColPivHouseholderQR<MatrixXd>(c.C.transpose()).rank() < c.C.rows()) {
    throw ConfigError(
        "constraints depend on each other (one of them follows from, or contradicts, the others); leave it out");
  }
}

}  // namespace

Regularizer regularizer(std::string_view name) {
  if (name == "l0") return Regularizer::l0;
  if (name == "l1") return Regularizer::l1;
  if (name == "l2") return Regularizer::l2;
  throw ConfigError("unknown penalty \"" + std::string(name) + "\"; use l0, l1 or l2");
}

std::span<const OptimizerRow> optimizer_registry() { return optimizers; }

const OptimizerRow& find_optimizer(std::string_view name) {
  for (const OptimizerRow& row : optimizers) {
    if (row.name == name) return row;
  }
  throw ConfigError("unknown optimizer \"" + std::string(name) + "\"; use stlsq, sr3 or best_subset");
}

std::vector<double> geometric_path(double largest, double factor, int n) {
  std::vector<double> path;
  for (int i = 0; i < n; ++i) path.push_back(largest * std::pow(factor, i));
  return path;
}

std::vector<double> lambda_path(const OptimizerRow& optimizer, const RegressionData& data,
                                const OptimizerOptions& options) {
  return optimizer.lambda_path(data.with_scaled_columns(column_scale(data, options)), options);
}

Fit fit(const OptimizerRow& optimizer, const RegressionData& data, const OptimizerOptions& options) {
  throw_if_interrupted();
  check(optimizer, data, options);
  const VectorXd scale = column_scale(data, options);
  OptimizerOptions scaled_options = options;
  scaled_options.constraints = scaled(options.constraints, scale, data.targets());
  Fit out = optimizer.run(data.with_scaled_columns(scale), scaled_options);
  out.coefficients *= scale.asDiagonal();
  out.full *= scale.asDiagonal();
  if (options.refit) {
    out.coefficients =
        constrained_least_squares(data, options.constraints, refit_support(out.coefficients, options.constraints));
    out.full = out.coefficients;
  }
  return out;
}

MatrixXd constrained_least_squares(const RegressionData& data, const LinearConstraints& constraints,
                                   const Support& support) {
  const Index terms = data.terms(), targets = data.targets();
  MatrixXd coefficients = MatrixXd::Zero(targets, terms);
  std::vector<Index> active;  // target · terms + term
  for (Index t = 0; t < targets; ++t) {
    std::vector<Index> of_target;
    for (Index j = 0; j < terms; ++j) {
      if (support(t, j)) of_target.push_back(j);
    }
    if (constraints.empty()) {
      const VectorXd solution = data.solve(of_target, t);
      for (std::size_t i = 0; i < of_target.size(); ++i)
        coefficients(t, of_target[i]) = solution[static_cast<Index>(i)];
    }
    for (Index j : of_target) active.push_back(t * terms + j);
  }
  if (constraints.empty()) return coefficients;

  // w = w₀ + N z with C w₀ = d and C N = 0, then least squares in z
  const Index n = static_cast<Index>(active.size());
  MatrixXd C(constraints.C.rows(), n);
  MatrixXd matrix = MatrixXd::Zero(targets * terms, n);
  VectorXd rhs(targets * terms);
  for (Index i = 0; i < n; ++i) {
    const Index w = active[static_cast<std::size_t>(i)];
    C.col(i) = constraints.C.col(w);
    matrix.col(i).segment(w / terms * terms, terms) = data.theta_factor().col(w % terms);
  }
  for (Index t = 0; t < targets; ++t) rhs.segment(t * terms, terms) = data.target_factor().col(t);
  if (n == 0) {
    if (!constraints.d.isZero(0.0)) fail_infeasible();
    return coefficients;
  }
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver(C);
  const VectorXd w0 = solver.solve(constraints.d);
  if ((C * w0 - constraints.d).norm() > 1e-9 * (1.0 + constraints.d.norm())) {
    fail_infeasible();
  }
  // the last rows of Z are an orthonormal basis of the null space of C
  const MatrixXd null_space =
      solver.colsPermutation() * MatrixXd(solver.matrixZ().transpose().rightCols(n - solver.rank()));
  VectorXd w = w0;
  if (null_space.cols() > 0) {
    w += null_space * Eigen::CompleteOrthogonalDecomposition<MatrixXd>(matrix * null_space).solve(rhs - matrix * w0);
  }
  for (Index i = 0; i < n; ++i) {
    // what the constraints force to zero is zero, not rounding
    const Index at = active[static_cast<std::size_t>(i)];
    if (std::abs(w[i]) > 1e-14 * w.cwiseAbs().maxCoeff()) coefficients(at / terms, at % terms) = w[i];
  }
  return coefficients;
}

}  // namespace gustlab
