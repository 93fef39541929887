#include "control/predictive.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"

namespace gustlab {
namespace predictive_test {

constexpr PredictiveControl::Limits limits{5.0, -6.0, 4.0};

double cost_of(const PredictiveControl& control, const Matrix3& error, const PredictiveControl::Inputs& w) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i) sum += control.axis(i).cost(error.row(static_cast<Eigen::Index>(i)), w[i]);
  return sum;
}

PredictiveControl make(int iterations) {
  return {PredictiveAxis(0.15, 3.0, 1.0), PredictiveAxis(0.03, 3.0, 1.0), limits, iterations};
}

PredictiveControl::Inputs moving_reference() {
  PredictiveControl::Inputs u_ref{};
  for (std::size_t k = 0; k < PredictiveAxis::stages; ++k) {
    u_ref[0][k] = 2.0 * std::sin(0.3 * static_cast<double>(k));
    u_ref[1][k] = -1.0;
    u_ref[2][k] = 0.1 * static_cast<double>(k);
  }
  return u_ref;
}

// GIVEN an axis without limits WHEN the regulator answers THEN the cost has no slope there, whatever the error
TEST(Predictive, RegulatorIsTheOptimumWithoutLimits) {
  for (const double damping : {0.71, 1.0, 2.0}) {
    const PredictiveAxis axis(0.15, 3.0, damping);
    PredictiveAxis::Inputs w, slope;
    for (const Vector3& error : {Vector3(1.0, 0.0, 0.0), Vector3(-0.2, 0.5, 1.5)}) {
      axis.regulate(error, w);
      axis.gradient(error, w, slope);
      for (const double value : slope) EXPECT_NEAR(value, 0.0, 1e-9);
    }
  }
}

TEST(Predictive, GradientIsTheSlopeOfTheCost) {
  const PredictiveAxis axis(0.1, 2.0, 0.9);
  const Vector3 error(0.4, -0.3, 0.8);
  PredictiveAxis::Inputs w, slope;
  for (std::size_t k = 0; k < w.size(); ++k) w[k] = std::cos(static_cast<double>(k));
  axis.gradient(error, w, slope);
  for (std::size_t k = 0; k < w.size(); ++k) {
    constexpr double step = 1e-4;
    PredictiveAxis::Inputs more = w, less = w;
    more[k] += step;
    less[k] -= step;
    EXPECT_NEAR(slope[k], (axis.cost(error, more) - axis.cost(error, less)) / (2.0 * step), 1e-6);
  }
}

// without a lag it is the PD of the other laws: K_p = w², K_v = 2 damping w; the stages of 50 ms take a little of it
TEST(Predictive, IsThePdOfItsBandwidthAndDamping) {
  for (const double damping : {0.8, 1.5}) {
    const PredictiveAxis axis(1e-3, 0.4, damping);
    PredictiveAxis::Inputs w;
    axis.regulate(Vector3(1.0, 0.0, 0.0), w);
    EXPECT_NEAR(w[0], -0.16, 0.05 * 0.16);
    axis.regulate(Vector3(0.0, 1.0, 0.0), w);
    EXPECT_NEAR(w[0], -2.0 * damping * 0.4, 0.05 * 2.0 * damping * 0.4);
  }
}

// GIVEN errors that ask for more than the limits WHEN they are solved THEN the answer is within them, no way from it towards another allowed
// one is downhill (the problem is convex), and the regulator cut to the limits is worse
TEST(Predictive, WithLimitsNothingAllowedIsBetter) {
  const PredictiveControl::Inputs u_ref = moving_reference();
  const RandomStream random(1, 0, "predictive");
  for (const double size : {0.5, 1.0, 3.0}) {
    Matrix3 error;
    error << size, -0.5, 0.2, -0.6 * size, 1.0, 0.0, 0.4 * size, 0.0, 0.5;
    PredictiveControl control = make(2000), cut = make(1);
    const PredictiveControl::Inputs w = control.solve(error, u_ref);
    const double least = cost_of(control, error, w);
    EXPECT_LT(least, cost_of(cut, error, cut.solve(error, u_ref)));

    for (std::size_t k = 0; k < PredictiveAxis::stages; ++k) {
      EXPECT_LE(std::hypot(u_ref[0][k] + w[0][k], u_ref[1][k] + w[1][k]), limits.horizontal_mps2 * (1.0 + 1e-12));
      EXPECT_LE(u_ref[2][k] + w[2][k], limits.most_vertical_mps2 + 1e-12);
      EXPECT_GE(u_ref[2][k] + w[2][k], limits.least_vertical_mps2 - 1e-12);
    }
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
      PredictiveControl::Inputs near = w;
      for (std::size_t k = 0; k < PredictiveAxis::stages; ++k) {
        const auto [turn, length, height, unused] = random.uniform4(trial * PredictiveAxis::stages + k);
        const double r = limits.horizontal_mps2 * std::sqrt(length);
        const std::array<double, 3> allowed{
            r * std::cos(2.0 * pi * turn), r * std::sin(2.0 * pi * turn),
            limits.least_vertical_mps2 + height * (limits.most_vertical_mps2 - limits.least_vertical_mps2)};
        for (std::size_t i = 0; i < 3; ++i) near[i][k] += 1e-3 * (allowed[i] - u_ref[i][k] - w[i][k]);
      }
      EXPECT_GE(cost_of(control, error, near), least - 1e-7 * least);
    }
  }
}

// the controller's fifty steps are within a hundredth of the optimum's cost
TEST(Predictive, FiftyStepsAreEnough) {
  const PredictiveControl::Inputs u_ref = moving_reference();
  Matrix3 error;
  error << 3.0, -0.5, 0.2, -2.0, 1.0, 0.0, 1.0, 0.0, 0.5;
  PredictiveControl quick = make(50), exact = make(5000);
  const double least = cost_of(exact, error, exact.solve(error, u_ref));
  EXPECT_LT(cost_of(quick, error, quick.solve(error, u_ref)), 1.01 * least);
}

}  // namespace predictive_test
}  // namespace gustlab
