#include "identification/regression_data.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// rows that are factored at once: a block stays in the first-level cache
constexpr Index block_rows = 256;

// Replaces `work` (more rows than columns) by the triangle of its QR factorisation, on top of zeros.
void triangularize(Eigen::Ref<MatrixXd> work) {
  const Index columns = work.cols();
  Eigen::HouseholderQR<Eigen::Ref<MatrixXd>> qr(work);
  work.topRows(columns).triangularView<Eigen::StrictlyLower>().setZero();
  work.bottomRows(work.rows() - columns).setZero();
}

// Shortest solution of min ‖matrix x − rhs‖; columns count as dependent below rounding error of so many samples.
MatrixXd shortest_solution(const MatrixXd& matrix, const MatrixXd& rhs, std::int64_t samples) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(matrix.rows(), matrix.cols());
  decomposition.setThreshold(std::numeric_limits<double>::epsilon() *
                             static_cast<double>(std::max<std::int64_t>(samples, matrix.cols())));
  return decomposition.compute(matrix).solve(rhs);
}

}  // namespace

RegressionData::RegressionData(const MatrixXd& theta, const MatrixXd& target)
    : terms_(theta.cols()), samples_(theta.rows()) {
  if (theta.rows() != target.rows()) throw std::invalid_argument("RegressionData: rows of theta and target differ");
  const Index columns = theta.cols() + target.cols();
  MatrixXd work = MatrixXd::Zero(columns + block_rows, columns);
  for (Index first = 0; first < theta.rows(); first += block_rows) {
    const Index rows = std::min(block_rows, theta.rows() - first);
    work.block(columns, 0, rows, terms_) = theta.middleRows(first, rows);
    work.block(columns, terms_, rows, target.cols()) = target.middleRows(first, rows);
    triangularize(work.topRows(columns + rows));
  }
  factor_ = work.topRows(columns);
  if (!factor_.allFinite())
    throw DataError("a term or a target is not finite (or too large to square); check the log's columns");
}

RegressionData RegressionData::merge(std::span<const RegressionData> parts) {
  const Index columns = parts.front().factor_.cols();
  MatrixXd work = MatrixXd::Zero(columns * static_cast<Index>(parts.size() + 1), columns);
  RegressionData out;
  out.terms_ = parts.front().terms_;
  Index row = columns;
  for (const RegressionData& part : parts) {
    work.middleRows(row, columns) = part.factor_;
    out.samples_ += part.samples_;
    row += columns;
  }
  triangularize(work);
  out.factor_ = work.topRows(columns);
  return out;
}

RegressionData RegressionData::with_scaled_columns(const VectorXd& scale) const {
  RegressionData out = *this;
  out.factor_.leftCols(terms_) *= scale.asDiagonal();
  return out;
}

VectorXd RegressionData::column_norms() const {
  VectorXd norms = factor_.leftCols(terms_).colwise().norm();
  return (norms.array() == 0.0).select(VectorXd::Ones(terms_), norms);
}

double RegressionData::condition_number() const {
  MatrixXd columns(terms_, 0);
  for (Index j = 0; j < terms_; ++j) {
    if (theta_factor().col(j).isZero(0.0)) continue;
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.rightCols<1>() = theta_factor().col(j);
  }
  if (columns.cols() == 0) return 1.0;
  const VectorXd values = Eigen::JacobiSVD<MatrixXd>(columns).singularValues();
  return values[0] / values[columns.cols() - 1];
}

VectorXd RegressionData::squared_error(const MatrixXd& coefficients) const {
  MatrixXd residual = factor_.rightCols(targets());
  residual.noalias() -= factor_.leftCols(terms_) * coefficients.transpose();
  return residual.colwise().squaredNorm();
}

VectorXd RegressionData::solve(std::span<const Index> support, Index target, double ridge) const {
  const Index n = static_cast<Index>(support.size());
  if (n == 0) return VectorXd(0);
  const Index extra = ridge > 0.0 ? n : 0;
  MatrixXd matrix = MatrixXd::Zero(terms_ + extra, n);
  VectorXd rhs = VectorXd::Zero(terms_ + extra);
  for (Index j = 0; j < n; ++j) {
    matrix.col(j).head(terms_) = theta_factor().col(support[static_cast<std::size_t>(j)]);
    if (extra) matrix(terms_ + j, j) = std::sqrt(ridge);
  }
  rhs.head(terms_) = target_factor().col(target);
  return shortest_solution(matrix, rhs, samples_);
}

MatrixXd RegressionData::least_squares() const {
  return shortest_solution(theta_factor(), target_factor(), samples_).transpose();
}

}  // namespace gustlab
