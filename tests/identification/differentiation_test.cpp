#include "identification/differentiation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/errors.hpp"
#include "identification/synthetic.hpp"

namespace gustlab {
namespace differentiation_test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd uneven_time(Index n) {
  VectorXd time_s(n);
  for (Index i = 0; i < n; ++i) time_s[i] = 3.0 + 0.02 * (static_cast<double>(i) + 0.4 * spread(i, 7.0));
  return time_s;
}

MatrixXd polynomial(const VectorXd& t, int degree, bool slope) {
  MatrixXd out(t.size(), 1);
  for (Index i = 0; i < t.size(); ++i) {
    double sum = 0.0;
    for (int k = slope ? 1 : 0; k <= degree; ++k)
      sum += (k + 1.0) * (slope ? k * std::pow(t[i] - 3.0, k - 1) : std::pow(t[i] - 3.0, k));
    out(i, 0) = sum;
  }
  return out;
}

TEST(FiniteDifference, IsExactForParabolasUpToTheEdgesOnAnyGrid) {
  const VectorXd t = uneven_time(40);
  const MatrixXd error = finite_difference(t, polynomial(t, 2, false)) - polynomial(t, 2, true);
  EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-11);
}

TEST(FiniteDifference, ErrorFallsWithTheSquareOfTheStep) {
  const auto error = [](Index n) {
    const VectorXd t = VectorXd::LinSpaced(n, 0.0, 1.0);
    return (finite_difference(t, t.array().sin().matrix()) - t.array().cos().matrix()).cwiseAbs().maxCoeff();
  };
  EXPECT_NEAR(error(101) / error(201), 4.0, 0.1);
}

TEST(FiniteDifference, TooShort) {
  EXPECT_THROW(finite_difference(VectorXd::LinSpaced(2, 0, 1), MatrixXd::Ones(2, 1)), DataError);
}

TEST(SavitzkyGolay, IsExactForItsDegreeUpToTheEdgesOnAnyGrid) {
  const VectorXd t = uneven_time(40);
  for (int degree : {1, 2, 3, 4}) {
    const MatrixXd y = polynomial(t, degree, false);
    EXPECT_LT((savitzky_golay(t, y, 9, degree, 0) - y).cwiseAbs().maxCoeff(), 1e-10) << degree;
    EXPECT_LT((savitzky_golay(t, y, 9, degree, 1) - polynomial(t, degree, true)).cwiseAbs().maxCoeff(), 1e-9) << degree;
  }
}

TEST(SavitzkyGolay, HasThePublishedWeights) {
  // the paper's table for five points and a parabola: (−3, 12, 17, 12, −3)/35; slope (−2, −1, 0, 1, 2)/10
  const VectorXd t = VectorXd::LinSpaced(5, 0.0, 4.0);
  const VectorXd smooth = savitzky_golay(t, MatrixXd::Identity(5, 5), 5, 2, 0).row(2);
  const VectorXd slope = savitzky_golay(t, MatrixXd::Identity(5, 5), 5, 2, 1).row(2);
  EXPECT_LT((smooth - (VectorXd(5) << -3, 12, 17, 12, -3).finished() / 35.0).norm(), 1e-14);
  EXPECT_LT((slope - (VectorXd(5) << -2, -1, 0, 1, 2).finished() / 10.0).norm(), 1e-14);
}

TEST(SavitzkyGolay, IsQuieterThanDifferences) {
  const VectorXd t = VectorXd::LinSpaced(500, 0.0, 5.0);
  MatrixXd y(500, 1);
  for (Index i = 0; i < 500; ++i) y(i, 0) = std::sin(t[i]) + 0.01 * spread(i, 2.0);
  const MatrixXd truth = t.array().cos();
  EXPECT_LT((savitzky_golay(t, y, 21, 3, 1) - truth).norm(), 0.2 * (finite_difference(t, y) - truth).norm());
}

TEST(RunningMean, KeepsLinesAndAveragesOverTheWindow) {
  const MatrixXd line = VectorXd::LinSpaced(20, -1.0, 3.0);
  EXPECT_LT((running_mean(line, 7) - line).cwiseAbs().maxCoeff(), 1e-14);
  MatrixXd pulse = MatrixXd::Zero(20, 1);
  pulse(10, 0) = 5.0;
  const MatrixXd out = running_mean(pulse, 5);
  for (Index i = 0; i < 20; ++i) EXPECT_DOUBLE_EQ(out(i, 0), i >= 8 && i <= 12 ? 1.0 : 0.0);
  EXPECT_EQ(running_mean(pulse, 1), pulse);
}

TEST(TrimmedRows, CutsBothEdges) {
  const VectorXd t = VectorXd::LinSpaced(11, 5.0, 6.0);
  EXPECT_EQ(trimmed_rows(t, 0.0), (std::pair<Index, Index>(0, 11)));
  EXPECT_EQ(trimmed_rows(t, 0.15), (std::pair<Index, Index>(2, 7)));
  EXPECT_EQ(trimmed_rows(t, 2.0).second, 0);
}

TEST(Differentiation, RefusesNonsense) {
  EXPECT_THROW((Differentiation{.smoothing_window = 4}.check()), ConfigError);
  EXPECT_THROW((Differentiation{.smoothing_window = 0}.check()), ConfigError);
  EXPECT_THROW((Differentiation{.window = 10}.check()), ConfigError);
  EXPECT_THROW((Differentiation{.window = 5, .degree = 5}.check()), ConfigError);
  EXPECT_THROW((Differentiation{.edge_s = -1.0}.check()), ConfigError);
  EXPECT_NO_THROW(Differentiation{}.check());
  EXPECT_THROW(derivative_kind("spline"), ConfigError);
  for (DerivativeKind kind : {DerivativeKind::finite_difference, DerivativeKind::savitzky_golay}) {
    EXPECT_EQ(derivative_kind(to_string(kind)), kind);
  }
}

}  // namespace differentiation_test
}  // namespace gustlab
