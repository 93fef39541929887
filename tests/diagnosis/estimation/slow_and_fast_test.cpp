// One size in slow and in fast changes: what the equations hold, and what resembles it over a part of the spectrum.
#include "diagnosis/estimation/slow_and_fast.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace slow_and_fast_test {

constexpr int samples = 3000;

double normal(int sample, std::uint32_t replicate) {
  return RandomStream(7, replicate, "test").normal4(static_cast<std::uint64_t>(sample))[0];
}

// a slow and a fast swing that are `slow` and `fast` times what the candidate says, in noise
double difference_of(double slow, double fast) {
  Eigen::MatrixXd rows(samples, 2);
  for (int k = 0; k < samples; ++k) {
    const double slowly = std::sin(2.0 * M_PI * k / 400.0), quickly = std::sin(2.0 * M_PI * k / 12.0);
    rows(k, 0) = slowly + quickly;
    rows(k, 1) = slow * slowly + fast * quickly + 0.5 * normal(k, 1);
  }
  const Eigen::VectorXd fitted = Eigen::VectorXd::Constant(1, rows.col(0).dot(rows.col(1)) / rows.col(0).squaredNorm());
  return slow_fast_difference(signature_series({{rows}}, column_products({{rows}}), {}, {0}, fitted), fitted);
}

TEST(SlowAndFast, WhatIsThereIsOfOneSize) { EXPECT_LT(difference_of(1.0, 1.0), 0.05); }

// far beyond its resonance a pendulum pulls the other way than one that follows
TEST(SlowAndFast, WhatResonatesIsNot) { EXPECT_GT(difference_of(1.5, -0.3), 1.0); }

TEST(SlowAndFast, AConstantHasNoFastChanges) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Ones(samples, 2);
  for (int k = 0; k < samples; ++k) rows(k, 1) += normal(k, 2);
  const Eigen::VectorXd fitted = Eigen::VectorXd::Constant(1, rows.col(1).mean());
  EXPECT_EQ(slow_fast_difference(signature_series({{rows}}, column_products({{rows}}), {}, {0}, fitted), fitted), 0.0);
}

// noise alone, in slow and in fast changes, is within its errors
TEST(SlowAndFast, NoiseIsNoDifference) { EXPECT_LT(difference_of(0.05, 0.05), 0.5); }

}  // namespace slow_and_fast_test
}  // namespace gustlab::diagnosis
