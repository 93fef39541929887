// Gram matrices against dense least squares on the rows that they are sums of.
#include "diagnosis/estimation/gram.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace gram_test {

constexpr int columns = 5, rows_per_block = 12, blocks = 8;

struct Rows {
  Eigen::MatrixXd all;  // columns, and z
  Grams grams;

  Rows() : all(rows_per_block * blocks, columns + 1) {
    const RandomStream random(5, 0, "gram_test");
    for (Eigen::Index i = 0; i < all.rows(); ++i)
      for (Eigen::Index j = 0; j < all.cols(); ++j)
        all(i, j) = random.normal4(static_cast<std::uint64_t>(i * all.cols() + j))[0];
    all.col(1) += 0.7 * all.col(0);
    all.col(columns) += 2.0 * all.col(0) - all.col(3);
    grams.columns = columns;
    grams.clusters = blocks / 2;
    grams.rows = static_cast<double>(all.rows());
    for (int b = 0; b < blocks; ++b) {
      grams.block.push_back(block(b).transpose() * block(b));
      grams.cluster.push_back(b / 2);
      grams.known.push_back(false);
      grams.flight.push_back(0);
      grams.time_s.push_back(0.5 * b);
    }
  }
  Eigen::MatrixXd block(int b) const { return all.middleRows(rows_per_block * b, rows_per_block); }
  Eigen::MatrixXd chosen(const std::vector<int>& of) const { return all(Eigen::all, of); }
  Eigen::VectorXd z() const { return all.col(columns); }
};

TEST(Gram, SolveIsLeastSquaresOnTheRows) {
  const Rows rows;
  const std::vector<int> of = {0, 3, 4};
  const Fit fit = solve(rows.grams.total(), of);
  const Eigen::VectorXd dense = rows.chosen(of).colPivHouseholderQr().solve(rows.z());
  EXPECT_LT((fit.coefficient - dense).norm(), 1e-7);
  EXPECT_NEAR(fit.loss, (rows.z() - rows.chosen(of) * dense).squaredNorm(), 1e-7);
}

// against the dense inverse; a ridge is relative to what a column says, so that it costs a weak column no more than a strong one
TEST(Gram, RidgedSolutionIsThatOfTheDenseMatrix) {
  const Rows rows;
  Eigen::MatrixXd A = rows.grams.total().topLeftCorner(columns, columns);
  A.row(1) *= 1e4;
  A.col(1) *= 1e4;
  const Eigen::MatrixXd right = rows.grams.total().rightCols(2).topRows(columns);
  for (const double ridge : {1e-12, 0.5}) {
    Eigen::MatrixXd ridged = A;
    ridged.diagonal() *= 1.0 + ridge;
    EXPECT_LT((solve_ridged(A, right, ridge) - ridged.inverse() * right).norm(), 1e-9) << ridge;
  }
}

// a column that says nothing has no coefficient
TEST(Gram, RidgedSolutionOfAnEmptyColumnIsZero) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2, 2);
  A(0, 0) = 4.0;
  EXPECT_TRUE(solve_ridged(A, Eigen::Vector2d(2.0, 0.0), 1e-10).isApprox(Eigen::Vector2d(0.5, 0.0), 1e-9));
}

TEST(Gram, ProjectedColumnsAreWhatTheOthersCannotSay) {
  const Rows rows;
  const std::vector<int> out = {0, 2};
  const Eigen::MatrixXd free = rows.chosen(out);
  const Eigen::MatrixXd left = rows.all - free * free.colPivHouseholderQr().solve(rows.all);
  EXPECT_LT((project_out(rows.grams.total(), out) - left.transpose() * left).norm(), 1e-5);
}

TEST(Gram, ShiftedRowsCountCoefficientsFromElsewhere) {
  Rows rows;
  const Eigen::VectorXd from = Eigen::VectorXd::LinSpaced(columns, -1.0, 0.5);
  const std::vector<int> of = {0, 1, 2, 3, 4};
  const Eigen::VectorXd before = solve(rows.grams.total(), of).coefficient;
  rows.grams.shift(from);
  EXPECT_LT((solve(rows.grams.total(), of).coefficient - before - from).norm(), 1e-6);
  Eigen::MatrixXd moved = rows.all;
  moved.col(columns) += rows.all.leftCols(columns) * from;
  EXPECT_LT((rows.grams.total() - moved.transpose() * moved).norm(), 1e-9);
}

// (XᵀX)⁻¹ Σ_clusters (Xᵀe)(Xᵀe)ᵀ (XᵀX)⁻¹, up to the correction for few clusters
TEST(Gram, ClusteredCovarianceIsTheSandwichOfTheRows) {
  const Rows rows;
  const std::vector<int> of = {0, 3};
  const Fit fit = solve(rows.grams.total(), of);
  const Eigen::MatrixXd X = rows.chosen(of);
  const Eigen::VectorXd e = rows.z() - X * fit.coefficient;
  const Eigen::MatrixXd bread = (X.transpose() * X).inverse();
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(2, 2);
  for (int c = 0; c < rows.grams.clusters; ++c) {
    const Eigen::VectorXd score = X.middleRows(2 * rows_per_block * c, 2 * rows_per_block).transpose() *
                                  e.segment(2 * rows_per_block * c, 2 * rows_per_block);
    meat += score * score.transpose();
  }
  const Eigen::MatrixXd dense = bread * meat * bread, found = clustered_covariance(rows.grams, of, fit.coefficient);
  const double correction = found(0, 0) / dense(0, 0);
  EXPECT_LT((found - correction * dense).norm(), 1e-6 * found.norm());
  EXPECT_GE(correction, 1.0 - 1e-6);
  EXPECT_LE(correction, 2.0);
}

// three seconds of rows, one every tenth of a second, the first still cold; two flights one after the other
TEST(Gram, BlocksAreHalfSecondsAndTwoOfThemAreACluster) {
  const Rows rows;
  const std::vector<int> of = {1, 3};
  const std::vector<int> with_z = {1, 3, columns};
  Whitened whitened;
  whitened.rows = rows.all(Eigen::seqN(0, 30), with_z);
  for (int k = 0; k < 30; ++k) {
    whitened.time_s.push_back(7.0 + 0.1 * k + (k > 0 ? 0.02 : 0.0));
    whitened.channel.push_back(k % 3);
    whitened.warm.push_back(k > 0);
  }
  Grams grams;
  for (const int flight : {0, 1}) GramBlocks(of, flight, columns, grams).add(whitened);
  EXPECT_EQ(grams.rows, 58.0);
  EXPECT_EQ(grams.flight, (std::vector<int>{0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1}));
  EXPECT_EQ(grams.cluster, (std::vector<int>{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5}));
  EXPECT_EQ(grams.clusters, 6);
  for (int b = 0; b < 6; ++b) {
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(5, columns + 1);
    block(Eigen::all, with_z) = rows.all(Eigen::seqN(5 * b, 5), with_z);
    if (b == 0) block.row(0).setZero();
    EXPECT_LT((grams.block[static_cast<std::size_t>(b)] - block.transpose() * block).norm(), 1e-9) << b;
    EXPECT_NEAR(grams.time_s[static_cast<std::size_t>(b)], 7.0 + 0.5 * b, 0.03) << b;
  }
}

TEST(Gram, LossesOfBlocksAreThoseOfTheirRows) {
  const Rows rows;
  const std::vector<int> of = {0, 3};
  const Fit fit = solve(rows.grams.total(), of);
  const Eigen::VectorXd losses = block_losses(rows.grams, of, fit.coefficient);
  for (int b = 0; b < blocks; ++b) {
    const Eigen::MatrixXd block = rows.block(b);
    EXPECT_NEAR(losses[b], (block.col(columns) - block(Eigen::all, of) * fit.coefficient).squaredNorm(), 1e-8);
  }
}

}  // namespace gram_test
}  // namespace gustlab::diagnosis
