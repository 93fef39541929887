#include "diagnosis/estimation/gram.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <iterator>
#include <utility>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::block_s;

Eigen::MatrixXd pick(const Eigen::MatrixXd& gram, const std::vector<int>& rows, const std::vector<int>& columns) {
  Eigen::MatrixXd part(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index i = 0; i < part.rows(); ++i)
    for (Eigen::Index j = 0; j < part.cols(); ++j)
      part(i, j) = gram(rows[static_cast<std::size_t>(i)], columns[static_cast<std::size_t>(j)]);
  return part;
}

Eigen::VectorXd pick_last(const Eigen::MatrixXd& gram, const std::vector<int>& rows) {
  Eigen::VectorXd part(static_cast<Eigen::Index>(rows.size()));
  for (Eigen::Index i = 0; i < part.size(); ++i) part[i] = gram(rows[static_cast<std::size_t>(i)], gram.cols() - 1);
  return part;
}

// what a fit leaves of z, as weights of all columns and z
Eigen::VectorXd left_by(const Grams& grams, const std::vector<int>& columns, const Eigen::VectorXd& coefficient) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(grams.columns + 1);
  weights(columns) = -coefficient;
  weights[grams.columns] = 1.0;
  return weights;
}

// columns that say nothing keep their scale at one, so that they come out as zero
Eigen::VectorXd scales(const Eigen::MatrixXd& square) {
  return square.diagonal().unaryExpr([](double d) { return d > 1e-18 ? std::sqrt(d) : 1.0; });
}

}  // namespace

Eigen::MatrixXd Grams::total() const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(columns + 1, columns + 1);
  for (const auto& b : block) sum += b;
  return sum;
}

double Grams::price(std::size_t numbers) const { return std::log(rows) * static_cast<double>(numbers); }

void Grams::add(int of_flight, double at_s, Eigen::MatrixXd more, bool is_known) {
  block.push_back(std::move(more));
  flight.push_back(of_flight);
  time_s.push_back(at_s);
  cluster.push_back(clusters++);
  known.push_back(is_known);
}

Eigen::MatrixXd shifted(Eigen::MatrixXd gram, const Eigen::VectorXd& d) {
  const Eigen::Index n = d.size();
  const Eigen::VectorXd move = gram.topLeftCorner(n, n) * d;
  const double zz = gram(n, n) + 2.0 * gram.col(n).head(n).dot(d) + d.dot(move);
  gram.col(n).head(n) += move;
  gram.row(n).head(n) = gram.col(n).head(n).transpose();
  gram(n, n) = zz;
  return gram;
}

void Grams::shift(const Eigen::VectorXd& d) {
  for (auto& b : block) b = shifted(std::move(b), d);
}

GramBlocks::GramBlocks(std::vector<int> columns, int flight, int catalogue_size, Grams& grams, bool one_block)
    : at_(std::move(columns)), flight_(flight), one_block_(one_block), grams_(grams) {
  grams_.columns = catalogue_size;
  at_.push_back(catalogue_size);
}

void GramBlocks::add(double time_s, bool warm, const double* columns, double y) {
  if (!start_s_) start_s_ = begin_s_ = time_s;
  const double block = std::floor((time_s - *start_s_) / block_s);
  if (block != block_) finish_block(), block_ = block, begin_s_ = time_s;
  if (!warm) return;
  const auto width = std::ssize(at_);
  if (count_ == kept_.rows()) kept_.conservativeResizeLike(Rows::Zero(2 * count_ + 64, padded(width)));
  kept_.row(count_).head(width - 1) = Eigen::Map<const Eigen::RowVectorXd>(columns, width - 1);
  kept_(count_++, width - 1) = y;
}

void GramBlocks::add(const Whitened& whitened) {
  const Eigen::Index y_at = whitened.rows.cols() - 1;
  for (std::size_t k = 0; k < whitened.time_s.size(); ++k) {
    const double* row = whitened.rows.data() + static_cast<Eigen::Index>(k) * (y_at + 1);
    add(whitened.time_s[k], whitened.warm[k], row, row[y_at]);
  }
}

void GramBlocks::finish_block() {
  if (count_ == 0) return;
  Rows local(kept_.cols(), kept_.cols());
  products_of_columns(kept_, count_, local);
  if (!one_block_ || blocks_ == 0) {
    grams_.block.emplace_back(Eigen::MatrixXd::Zero(grams_.columns + 1, grams_.columns + 1));
    grams_.flight.push_back(flight_);
    grams_.known.push_back(false);
    grams_.time_s.push_back(begin_s_);
    if (blocks_ % 2 == 0) last_cluster_ = grams_.clusters++;
    grams_.cluster.push_back(last_cluster_);
  }
  ++blocks_;
  Eigen::MatrixXd& full = grams_.block.back();
  for (std::size_t j = 0; j < at_.size(); ++j)
    for (std::size_t i = 0; i < at_.size(); ++i)
      full(at_[i], at_[j]) += local(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  grams_.rows += static_cast<double>(count_);
  count_ = 0;
}

void append(Grams&& more, Grams& grams) {
  grams.columns = more.columns;
  grams.block.insert(grams.block.end(), std::make_move_iterator(more.block.begin()),
                     std::make_move_iterator(more.block.end()));
  grams.flight.insert(grams.flight.end(), more.flight.begin(), more.flight.end());
  grams.time_s.insert(grams.time_s.end(), more.time_s.begin(), more.time_s.end());
  grams.known.insert(grams.known.end(), more.known.begin(), more.known.end());
  for (const int cluster : more.cluster) grams.cluster.push_back(grams.clusters + cluster);
  grams.clusters += more.clusters;
  grams.rows += more.rows;
}

Fit solve(const Eigen::MatrixXd& gram, const std::vector<int>& columns, double ridge) {
  Fit fit;
  const double zz = gram(gram.rows() - 1, gram.cols() - 1);
  fit.loss = zz;
  if (columns.empty()) return fit;
  const Eigen::MatrixXd A = pick(gram, columns, columns);
  const Eigen::VectorXd right = pick_last(gram, columns), scale = scales(A);
  Eigen::MatrixXd unit = scale.cwiseInverse().asDiagonal() * A * scale.cwiseInverse().asDiagonal();
  unit.diagonal().array() += ridge;
  fit.coefficient = unit.ldlt().solve(right.cwiseQuotient(scale)).cwiseQuotient(scale);
  fit.loss = zz - 2.0 * right.dot(fit.coefficient) + fit.coefficient.dot(A * fit.coefficient);
  return fit;
}

Eigen::MatrixXd solve_ridged(const Eigen::MatrixXd& A, const Eigen::MatrixXd& right, double ridge) {
  const Eigen::VectorXd scale = A.diagonal().cwiseMax(1e-18).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd unit = scale.asDiagonal() * A * scale.asDiagonal();
  unit.diagonal().array() += ridge;
  return scale.asDiagonal() * unit.ldlt().solve(scale.asDiagonal() * right);
}

Eigen::MatrixXd project_out(const Eigen::MatrixXd& gram, const std::vector<int>& columns) {
  if (columns.empty()) return gram;
  std::vector<int> all(static_cast<std::size_t>(gram.cols()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const Eigen::MatrixXd A = pick(gram, columns, columns), C = pick(gram, columns, all);
  const Eigen::VectorXd scale = scales(A);
  Eigen::MatrixXd unit = scale.cwiseInverse().asDiagonal() * A * scale.cwiseInverse().asDiagonal();
  unit.diagonal().array() += 1e-10;
  const Eigen::MatrixXd scaled = scale.cwiseInverse().asDiagonal() * C;
  Eigen::MatrixXd left = gram - scaled.transpose() * unit.ldlt().solve(scaled);
  for (const int c : columns) {
    left.row(c).setZero();
    left.col(c).setZero();
  }
  return left;
}

Eigen::MatrixXd clustered_covariance(const Grams& grams, const std::vector<int>& columns,
                                     const Eigen::VectorXd& coefficient) {
  const Eigen::MatrixXd total = grams.total();
  const auto size = static_cast<Eigen::Index>(columns.size());
  const Eigen::MatrixXd H = pick(total, columns, columns);
  // what is known beforehand scatters as it is said to
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(grams.clusters, size), said = Eigen::MatrixXd::Zero(size, size);
  const Eigen::VectorXd left = left_by(grams, columns, coefficient);
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    if (grams.known[b]) {
      said += pick(grams.block[b], columns, columns);
      continue;
    }
    const Eigen::VectorXd score = grams.block[b] * left;
    scores.row(grams.cluster[b]) += score(columns).transpose();
  }
  // pseudo-inverse in unit scale: directions that the data do not see stay out
  const Eigen::VectorXd scale = scales(H);
  const Eigen::MatrixXd unit = scale.cwiseInverse().asDiagonal() * H * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit);
  const Eigen::VectorXd inverse = eigen.eigenvalues().unaryExpr([](double v) { return v > 1e-10 ? 1.0 / v : 0.0; });
  const Eigen::MatrixXd bread = scale.cwiseInverse().asDiagonal() *
                                (eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose()) *
                                scale.cwiseInverse().asDiagonal();
  const double small_sample = static_cast<double>(grams.clusters) / std::max(1, grams.clusters - 1);
  return bread * (small_sample * scores.transpose() * scores + said) * bread;
}

double clustered_variance(const Grams& grams, const Eigen::VectorXd& pattern, const Eigen::VectorXd& left) {
  std::vector<double> score(static_cast<std::size_t>(grams.clusters), 0.0);
  double information = 0.0, squares = 0.0;
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    const Eigen::VectorXd seen = grams.block[b] * pattern;
    information += seen.dot(pattern);
    if (grams.known[b]) squares += seen.dot(pattern);
    else score[static_cast<std::size_t>(grams.cluster[b])] += seen.dot(left);
  }
  for (const double s : score) squares += s * s;
  return squares / (information * information);
}

Eigen::VectorXd block_losses(const Grams& grams, const std::vector<int>& columns, const Eigen::VectorXd& coefficient) {
  Eigen::VectorXd losses(static_cast<Eigen::Index>(grams.block.size()));
  const Eigen::VectorXd left = left_by(grams, columns, coefficient);
  for (Eigen::Index b = 0; b < losses.size(); ++b)
    losses[b] = left.dot(grams.block[static_cast<std::size_t>(b)] * left);
  return losses;
}

}  // namespace gustlab::diagnosis
