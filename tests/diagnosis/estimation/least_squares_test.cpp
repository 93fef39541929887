// How Ceres is asked: a decay whose rate is known, from a start beyond which the residual is not defined.
#include "diagnosis/estimation/least_squares.hpp"

#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

namespace gustlab::diagnosis {
namespace least_squares_test {

// exp(−rate t) at t = 1…5 against rate 0.7; a rate below 0.1 is refused
struct Decay final : ceres::SizedCostFunction<5, 1> {
  bool Evaluate(double const* const* rate, double* residual, double** jacobian) const override {
    if (rate[0][0] < 0.1) return false;
    for (int t = 1; t <= 5; ++t) {
      residual[t - 1] = std::exp(-rate[0][0] * t) - std::exp(-0.7 * t);
      if (jacobian && jacobian[0]) jacobian[0][t - 1] = -t * std::exp(-rate[0][0] * t);
    }
    return true;
  }
};

ceres::Solver::Summary fit(double& rate, const FewUnknowns& how) {
  ceres::Problem problem;
  problem.AddResidualBlock(new Decay, nullptr, &rate);
  ceres::Solver::Summary summary;
  ceres::Solve(few_unknowns(how), &problem, &summary);
  return summary;
}

TEST(FewUnknowns, SettleOnTheAnswerPastStepsThatAreRefused) {
  double rate = 3.0;  // the first step by Gauss and Newton alone would go to a negative rate
  const ceres::Solver::Summary summary = fit(rate, {.settled = 1e-12});
  EXPECT_NEAR(rate, 0.7, 1e-6);
  EXPECT_GT(summary.num_unsuccessful_steps, 0);
  EXPECT_EQ(summary.num_threads_used, 1);
}

TEST(FewUnknowns, EndAfterSoManySteps) {
  double rate = 3.0;
  const ceres::Solver::Summary summary = fit(rate, {.most_steps = 3});
  EXPECT_LE(summary.num_successful_steps + summary.num_unsuccessful_steps, 4);
  EXPECT_GT(std::abs(rate - 0.7), 1e-3);
}

}  // namespace least_squares_test
}  // namespace gustlab::diagnosis
