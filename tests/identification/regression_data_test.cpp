// The triangle of a regression against dense solutions on all its rows.
#include "identification/regression_data.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <limits>

#include "gustlab/errors.hpp"
#include "gustlab/random.hpp"

namespace gustlab {
namespace regression_data_test {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, const char* stream) {
  const RandomStream random(8, 0, stream);
  MatrixXd out(rows, columns);
  for (Eigen::Index i = 0; i < out.size(); ++i) out.data()[i] = random.normal4(static_cast<std::uint64_t>(i))[0];
  return out;
}

// more rows than are factored at once, not a multiple of it
struct Problem {
  MatrixXd theta = random_matrix(700, 4, "theta"), target = random_matrix(700, 2, "target");
  Problem() {
    theta.col(2) *= 1e4;
    target.col(0) += 2.0 * theta.col(0) - 3e-4 * theta.col(2);
  }
  RegressionData data() const { return {theta, target}; }
};

TEST(RegressionData, FitsAsTheRowsDo) {
  const Problem p;
  const RegressionData data = p.data();
  EXPECT_EQ(data.samples(), 700);
  EXPECT_EQ(data.terms(), 4);
  EXPECT_EQ(data.targets(), 2);
  const MatrixXd dense = p.theta.colPivHouseholderQr().solve(p.target);
  EXPECT_LT((data.least_squares() - dense.transpose()).norm(), 1e-9);
  const VectorXd left = (p.target - p.theta * dense).colwise().squaredNorm();
  EXPECT_LT((data.unreached() - left).norm(), 1e-9 * left.norm());
  const MatrixXd other = random_matrix(2, 4, "other");
  const VectorXd error = (p.target - p.theta * other.transpose()).colwise().squaredNorm();
  EXPECT_LT((data.squared_error(other) - error).norm(), 1e-9 * error.norm());
}

TEST(RegressionData, SolvesOnASupportWithARidge) {
  const Problem p;
  const std::vector<Eigen::Index> support = {3, 0};
  const MatrixXd of = p.theta(Eigen::all, std::vector<int>{3, 0});
  for (const double ridge : {0.0, 50.0}) {
    const VectorXd dense =
        (of.transpose() * of + ridge * MatrixXd::Identity(2, 2)).ldlt().solve(of.transpose() * p.target.col(0));
    EXPECT_LT((p.data().solve(support, 0, ridge) - dense).norm(), 1e-9) << ridge;
  }
  EXPECT_EQ(p.data().solve({}, 1).size(), 0);
}

TEST(RegressionData, OfPartsIsThatOfAll) {
  const Problem p;
  const std::vector<RegressionData> parts = {{p.theta.topRows(300), p.target.topRows(300)},
                                             {p.theta.bottomRows(400), p.target.bottomRows(400)}};
  const RegressionData merged = RegressionData::merge(parts);
  EXPECT_EQ(merged.samples(), 700);
  EXPECT_LT((merged.least_squares() - p.data().least_squares()).norm(), 1e-9);
  EXPECT_LT((merged.unreached() - p.data().unreached()).norm(), 1e-6);
}

TEST(RegressionData, KnowsItsColumns) {
  Problem p;
  const Eigen::JacobiSVD<MatrixXd> svd(p.theta);
  EXPECT_NEAR(p.data().condition_number(), svd.singularValues()[0] / svd.singularValues()[3], 1e-3);
  EXPECT_LT((p.data().column_norms() - p.theta.colwise().norm().transpose()).norm(), 1e-6);
  const VectorXd scale = Eigen::Vector4d(1.0, 2.0, 1e-4, 0.5);
  EXPECT_LT(
      (p.data().with_scaled_columns(scale).column_norms() - p.theta.colwise().norm().transpose().cwiseProduct(scale))
          .norm(),
      1e-9);
  p.theta.col(1).setZero();
  EXPECT_EQ(p.data().column_norms()[1], 1.0);
  EXPECT_TRUE(std::isfinite(p.data().condition_number()));
}

// the shortest of all solutions
TEST(RegressionData, SharesBetweenDependentColumns) {
  Problem p;
  p.theta.col(3) = p.theta.col(0);
  const MatrixXd fit = p.data().least_squares();
  EXPECT_NEAR(fit(0, 0), fit(0, 3), 1e-9);
  EXPECT_NEAR(fit(0, 0) + fit(0, 3), 2.0, 0.1);
}

TEST(RegressionData, RefusesWhatIsNotFinite) {
  Problem p;
  p.theta(650, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(p.data(), DataError);
  EXPECT_THROW(RegressionData(p.theta, p.target.topRows(10)), std::invalid_argument);
}

}  // namespace regression_data_test
}  // namespace gustlab
