#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "identification/optimizer.hpp"
#include "util/interrupt.hpp"

namespace gustlab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// u = argmin λ R(u) + ‖w − u‖²/(2ν); weight = λ ν
void proximal_step(Regularizer penalty, double weight, const MatrixXd& w, MatrixXd& u) {
  switch (penalty) {
    case Regularizer::l0: {
      const double threshold = std::sqrt(2.0 * weight);
      u = (w.array().abs() > threshold).select(w, 0.0);
      return;
    }
    case Regularizer::l1:
      u = w.array().sign() * (w.array().abs() - weight).max(0.0);
      return;
    case Regularizer::l2:
      u = w / (1.0 + 2.0 * weight);
      return;
  }
}

// (ΘᵀΘ + I/ν)⁻¹ from the triangle of [R; I/√ν], without squaring the condition number
MatrixXd relaxed_inverse(const RegressionData& data, double nu) {
  const Index n = data.terms();
  MatrixXd stacked(2 * n, n);
  stacked << MatrixXd(data.theta_factor()), MatrixXd::Identity(n, n) / std::sqrt(nu);
  const Eigen::HouseholderQR<MatrixXd> qr(stacked);
  const MatrixXd inverse = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>().solve(MatrixXd::Identity(n, n));
  return inverse * inverse.transpose();
}

}  // namespace

Fit sr3(const RegressionData& data, const OptimizerOptions& options) {
  const Index n = data.terms(), targets = data.targets();
  const LinearConstraints& constraints = options.constraints;
  // column t of w and u belongs to target t, so that w.data() is the vector of the constraints
  const MatrixXd inverse = relaxed_inverse(data, options.nu);
  const MatrixXd from_data = inverse * (MatrixXd(data.theta_factor()).transpose() * data.target_factor());
  const MatrixXd from_u = inverse / options.nu;

  // nearest point of C w = d in the metric of H: w ← w + K (d − C w), K = H⁻¹Cᵀ (C H⁻¹ Cᵀ)⁻¹
  MatrixXd K(n * targets, constraints.C.rows());
  if (!constraints.empty()) {
    MatrixXd HC(n * targets, constraints.C.rows());
    for (Index t = 0; t < targets; ++t) {
      HC.middleRows(t * n, n) = inverse * constraints.C.middleCols(t * n, n).transpose();
    }
    K = (constraints.C * HC).ldlt().solve(HC.transpose()).transpose();
  }

  Fit out;
  out.converged = false;
  MatrixXd u = data.least_squares().transpose(), w(n, targets), last(n, targets);
  Eigen::Map<VectorXd> stacked_w(w.data(), w.size());
  VectorXd violation(constraints.C.rows());
  while (out.iterations < options.max_iterations && !out.converged) {
    throw_if_interrupted();
    last = u;
    w = from_data;
    w.noalias() += from_u * u;
    if (!constraints.empty()) {
      violation = constraints.d;
      violation.noalias() -= constraints.C * stacked_w;
      stacked_w.noalias() += K * violation;
    }
    proximal_step(options.penalty, options.lambda * options.nu, w, u);
    ++out.iterations;
    // below rounding error of u no smaller step can be told
    const double change = (u - last).norm();
    out.converged =
        change < options.tolerance * options.nu || change <= 4.0 * std::numeric_limits<double>::epsilon() * u.norm();
  }
  out.coefficients = u.transpose();
  out.full = w.transpose();
  return out;
}

}  // namespace gustlab
