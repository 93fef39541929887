// The least-squares problem Y ≈ Θ Ξᵀ, reduced once to what every optimizer needs.
//
// A QR factorisation [Θ Y] = Q R keeps all of it in R, which has one row and column per term and target, whatever the
// number of samples: fits on any support, exact residual sums for any coefficients, column norms and the condition
// number. Unlike the Gram matrix ΘᵀΘ it does not square the condition number. Trajectories and folds are merged by
// factoring their stacked triangles.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace gustlab {

class RegressionData {
 public:
  // theta: samples × terms, target: samples × targets; all finite, otherwise DataError.
  RegressionData(const Eigen::MatrixXd& theta, const Eigen::MatrixXd& target);
  // All samples of `parts`, which have the same terms and targets; at least one.
  static RegressionData merge(std::span<const RegressionData> parts);
  // The same problem with column j of Θ multiplied by scale[j].
  RegressionData with_scaled_columns(const Eigen::VectorXd& scale) const;

  Eigen::Index terms() const { return terms_; }
  Eigen::Index targets() const { return factor_.cols() - terms_; }
  std::int64_t samples() const { return samples_; }

  // R_ΘΘ (terms × terms, upper triangular) with R_ΘΘᵀ R_ΘΘ = ΘᵀΘ
  auto theta_factor() const { return factor_.topLeftCorner(terms_, terms_); }
  // R_ΘY (terms × targets) with R_ΘΘᵀ R_ΘY = ΘᵀY
  auto target_factor() const { return factor_.topRightCorner(terms_, targets()); }

  // Σ (y − ŷ)² that is left when every term is fitted, per target
  Eigen::VectorXd unreached() const { return factor_.bottomRightCorner(targets(), targets()).colwise().squaredNorm(); }

  // Euclidean length of each column of Θ; 1 where the column is zero, so that it can divide.
  Eigen::VectorXd column_norms() const;
  // Largest over smallest singular value of Θ without its columns of zeros.
  double condition_number() const;
  // Σ over samples of (y − Θ ξ)², per target; coefficients: targets × terms.
  Eigen::VectorXd squared_error(const Eigen::MatrixXd& coefficients) const;
  // argmin ‖y − Θ_S w‖² + ridge ‖w‖² for one target; shortest such w when Θ_S has dependent columns.
  Eigen::VectorXd solve(std::span<const Eigen::Index> support, Eigen::Index target, double ridge = 0.0) const;
  // The same with every term and without ridge, targets × terms.
  Eigen::MatrixXd least_squares() const;

 private:
  RegressionData() = default;
  Eigen::MatrixXd factor_;  // upper triangular, (terms + targets)²
  Eigen::Index terms_ = 0;
  std::int64_t samples_ = 0;
};

}  // namespace gustlab
