#include "control/adaptation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "gustlab/random.hpp"

namespace gustlab {
namespace adaptation_test {

using Row = Adaptation::Row;
using Parameters = Adaptation::Parameters;

Row features(int n, std::uint64_t i) {
  Row phi(n);
  const auto a = RandomStream(1, 0, "adaptation").normal4(i), b = RandomStream(1, 0, "adaptation").normal4(i, 1);
  for (int k = 0; k < n; ++k) phi[k] = k < 4 ? a[static_cast<std::size_t>(k)] : b[static_cast<std::size_t>(k - 4)];
  return phi;
}

TEST(Adaptation, GivenNothingLearnsNothing) {
  Adaptation adaptation({}, Parameters::Zero(3, 3), 0.02);
  for (std::uint64_t i = 0; i < 100; ++i)
    EXPECT_EQ(adaptation.update(features(3, i), Vector3::Zero(), Vector3::Zero()), Vector3::Zero());
}

// GIVEN y = φ A with rich φ WHEN it adapts without a leak THEN it finds A
TEST(Adaptation, FindsConstantParameters) {
  Parameters truth(3, 3);
  truth << 1.0, -2.0, 0.5, 0.3, 0.7, -1.1, 2.0, 0.0, 0.4;
  for (const CovarianceLaw law : {CovarianceLaw::corrected, CovarianceLaw::printed}) {
    Adaptation adaptation({.leak_radps = 0.0, .law = law}, Parameters::Zero(3, 3), 0.02);
    for (std::uint64_t i = 0; i < 3000; ++i) {
      const Row phi = features(3, i);
      adaptation.update(phi, (phi * truth).transpose(), Vector3::Zero());
    }
    EXPECT_LT((adaptation.parameters() - truth).norm(), 1e-3);
  }
}

// without leak and growth the law is recursive least squares: the batch solution with its prior
TEST(Adaptation, WithoutLeakAndGrowthIsLeastSquares) {
  const double period_s = 0.02, noise = 0.7, start = 2.0;
  Adaptation adaptation({.leak_radps = 0.0, .noise = noise, .growth = 0.0, .start_covariance = start},
                        Parameters::Zero(2, 3), period_s);
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity() / start;
  Eigen::Matrix<double, 2, 3> right = Eigen::Matrix<double, 2, 3>::Zero();
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Row phi = features(2, i);
    const Vector3 y(std::sin(0.3 * static_cast<double>(i)), 1.0, -0.2 * static_cast<double>(i));
    adaptation.update(phi, y, Vector3::Zero());
    information += period_s / noise * phi.transpose() * phi;
    right += period_s / noise * phi.transpose() * y.transpose();
  }
  EXPECT_LT((adaptation.covariance() - information.inverse()).norm(), 1e-10);
  EXPECT_LT((adaptation.parameters() - information.inverse() * right).norm(), 1e-9);
}

// small steps follow the differential equations
TEST(Adaptation, FollowsItsDifferentialEquations) {
  const Row phi = (Row(2) << 1.0, 0.6).finished();
  const Vector3 y(0.5, -0.2, 0.1), s(0.03, 0.0, -0.02);
  for (const CovarianceLaw law : {CovarianceLaw::corrected, CovarianceLaw::printed}) {
    const Adaptation::Options options{
        .leak_radps = 0.4, .noise = 0.8, .growth = 1.5, .start_covariance = 1.2, .law = law};
    const double step = 1e-5;
    Adaptation adaptation(options, Parameters::Zero(2, 3), step);
    Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();
    Eigen::Matrix2d P = 1.2 * Eigen::Matrix2d::Identity();
    for (int i = 0; i < 50000; ++i) {
      adaptation.update(phi, y, s);
      const Eigen::Matrix<double, 1, 3> error = phi * A - y.transpose();
      const Eigen::Matrix<double, 2, 3> dA =
          -0.4 * A - P * phi.transpose() * error / 0.8 + P * phi.transpose() * s.transpose();
      Eigen::Matrix2d shrink = P * phi.transpose() * phi;
      if (law == CovarianceLaw::corrected) shrink = shrink * P;
      P += step * (-0.8 * P + 1.5 * Eigen::Matrix2d::Identity() - shrink / 0.8);
      A += step * dA;
    }
    EXPECT_LT((adaptation.parameters() - A).norm(), 1e-4 * A.norm());
    EXPECT_LT((adaptation.covariance() - P).norm(), 1e-4 * P.norm());
  }
}

// GIVEN anything at all WHEN it adapts for long, at any step, THEN P stays symmetric and positive definite
TEST(Adaptation, CovarianceStaysPositiveDefinite) {
  for (const double period_s : {1e-4, 0.02, 1.0})
    for (const double scale : {1e-3, 1.0, 1e3}) {
      Adaptation adaptation({.leak_radps = 0.1, .noise = 1e-3, .growth = 10.0}, Parameters::Zero(7, 3), period_s);
      for (std::uint64_t i = 0; i < 20000; ++i)
        adaptation.update(scale * features(7, i), Vector3::Ones(), Vector3::Ones());
      const Eigen::MatrixXd P = adaptation.covariance();
      EXPECT_LT((P - P.transpose()).norm(), 1e-9 * P.norm());
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(P).eigenvalues().minCoeff(), 0.0)
          << period_s << " " << scale;
    }
}

// GIVEN a residual and a tracking error that never end WHEN there is a leak THEN parameters stay bounded
TEST(Adaptation, ParametersStayBounded) {
  for (const CovarianceLaw law : {CovarianceLaw::corrected, CovarianceLaw::printed}) {
    Adaptation adaptation({.leak_radps = 0.1, .law = law}, Parameters::Zero(3, 3), 0.02);
    double most = 0.0;
    for (std::uint64_t i = 0; i < 50000; ++i) {
      adaptation.update(features(3, i % 7), Vector3::Constant(3.0), Vector3::Constant(1.0));
      most = std::max(most, adaptation.parameters().norm());
    }
    EXPECT_LT(most, 1e3);
  }
}

TEST(Adaptation, PrintedLawLosesSymmetryAndKeepsAHigherGain) {
  const Row phi = (Row(2) << 1.0, 0.6).finished();
  Adaptation corrected({.growth = 4.0}, Parameters::Zero(2, 3), 0.02);
  Adaptation printed({.growth = 4.0, .law = CovarianceLaw::printed}, Parameters::Zero(2, 3), 0.02);
  for (std::uint64_t i = 0; i < 500; ++i) {
    const Row wobble = phi + 0.3 * features(2, i);
    corrected.update(wobble, Vector3::Ones(), Vector3::Zero());
    printed.update(wobble, Vector3::Ones(), Vector3::Zero());
  }
  EXPECT_GT((printed.covariance() - printed.covariance().transpose()).norm(), 1e-3);
  EXPECT_GT(phi * printed.covariance() * phi.transpose(), phi * corrected.covariance() * phi.transpose());
}

}  // namespace adaptation_test
}  // namespace gustlab
