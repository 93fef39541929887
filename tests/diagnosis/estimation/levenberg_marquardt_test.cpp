// The small least-squares solver on problems whose answer is known.
#include "diagnosis/estimation/levenberg_marquardt.hpp"

#include <gtest/gtest.h>

namespace gustlab::diagnosis {
namespace {

using Vector = Eigen::VectorXd;
using Equations = NormalEquations<Eigen::MatrixXd, Vector>;

// (10 (y − x²), 1 − x): a narrow bent valley with its floor at (1, 1) (Rosenbrock, Computer Journal 3, 1960)
Vector rosenbrock(const Vector& at) { return Vector{{10.0 * (at[1] - at[0] * at[0]), 1.0 - at[0]}}; }

Equations normal_equations(const Vector& at) {
  const Eigen::MatrixXd J{{-20.0 * at[0], 10.0}, {-1.0, 0.0}};
  return {J.transpose() * J, -J.transpose() * rosenbrock(at)};
}

double squares(const Vector& at) { return rosenbrock(at).squaredNorm(); }

TEST(LevenbergMarquardt, FollowsABentValleyToItsFloor) {
  Vector at{{-1.2, 1.0}};
  Equations last;
  const double cost = minimise(at, squares(at), {.settled = 1e-12, .most_steps = 100}, normal_equations, squares, last);
  EXPECT_NEAR(at[0], 1.0, 1e-6);
  EXPECT_NEAR(at[1], 1.0, 1e-6);
  EXPECT_LT(cost, 1e-12);
}

TEST(LevenbergMarquardt, NeverGoesUpAndStopsAfterItsSteps) {
  Vector at{{-1.2, 1.0}};
  double before = squares(at);
  for (int step = 0; step < 5; ++step) {
    Equations last;
    const double cost = minimise(at, before, {.most_steps = 1}, normal_equations, squares, last);
    EXPECT_LE(cost, before);
    EXPECT_EQ(cost, squares(at));
    before = cost;
  }
  EXPECT_GT(before, 1e-3);
}

// a step into what has no cost is no step
TEST(LevenbergMarquardt, StaysWhereTheCostIsFinite) {
  const auto cost = [](const Vector& at) { return at[0] > 0.0 ? std::pow(std::log(at[0]), 2) : std::nan(""); };
  const auto equations = [](const Vector& at) {
    const double slope = 1.0 / at[0];
    return Equations{Eigen::MatrixXd::Constant(1, 1, slope * slope), Vector::Constant(1, -slope * std::log(at[0]))};
  };
  Vector at = Vector::Constant(1, 5.0);  // the full step from here goes below zero
  Equations last;
  minimise(at, cost(at), {.settled = 1e-12}, equations, cost, last);
  EXPECT_NEAR(at[0], 1.0, 1e-6);
}

}  // namespace
}  // namespace gustlab::diagnosis
