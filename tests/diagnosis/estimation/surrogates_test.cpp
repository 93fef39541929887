// The null that assumes no model of the rest: signatures moved along their flights.
#include "diagnosis/estimation/surrogates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace surrogates_test {

constexpr int samples = 3000;

// a series that remembers for `memory` samples, of unit variance
Eigen::VectorXd slow_series(std::uint32_t replicate, double memory) {
  const RandomStream random(7, replicate, "test");
  Eigen::VectorXd x(samples);
  double state = 0.0;
  const double keep = std::exp(-1.0 / memory);
  for (int k = 0; k < samples; ++k)
    x[k] = state = keep * state + std::sqrt(1.0 - keep * keep) * random.normal4(static_cast<std::uint64_t>(k))[0];
  return x;
}

SurrogateTest test_of(const Eigen::VectorXd& signature, const Eigen::VectorXd& left, double size) {
  Eigen::MatrixXd rows(samples, 2);
  rows << signature, size * signature + left;
  const double fitted = signature.dot(rows.col(1)) / signature.squaredNorm();
  const Eigen::VectorXd coefficient = Eigen::VectorXd::Constant(1, fitted);
  return surrogate_test(signature_series({{rows}}, column_products({{rows}}), {}, {0}, coefficient), coefficient);
}

TEST(Surrogates, WhiteResidualsAreNotInflated) {
  const SurrogateTest t = test_of(slow_series(1, 50.0), slow_series(2, 0.01), 0.2);
  EXPECT_NEAR(t.inflation, 1.0, 0.3);
  EXPECT_LE(t.p_value, 0.005);
  EXPECT_GT(t.p_value, 0.0);  // the true signature is one of those that gain as much
  EXPECT_TRUE(t.movable);
}

TEST(Surrogates, SlowResidualsInflateWhatChanceGains) {
  const SurrogateTest t = test_of(slow_series(1, 50.0), slow_series(2, 50.0), 0.0);
  EXPECT_GT(t.inflation, 10.0);
  EXPECT_GT(t.p_value, 0.02);
}

TEST(Surrogates, ATrueSignatureBesideSlowResidualsIsFound) {
  EXPECT_LE(test_of(slow_series(1, 50.0), slow_series(2, 50.0), 1.0).p_value, 0.005);
}

// one lap later the same path meets its own effect again: residuals of the whole model do not hold it
TEST(Surrogates, APathThatRepeatsItselfDoesNotHideItsEffect) {
  Eigen::VectorXd circle(samples);
  for (int k = 0; k < samples; ++k) circle[k] = std::sin(2.0 * M_PI * k / 300.0);
  EXPECT_LE(test_of(circle, slow_series(3, 5.0), 1.0).p_value, 0.005);
}

TEST(Surrogates, AConstantCannotBeMoved) {
  EXPECT_FALSE(test_of(Eigen::VectorXd::Ones(samples), slow_series(4, 5.0), 1.0).movable);
}

// about one of twenty spurious signatures reaches p = 0.05
TEST(Surrogates, TheirPValuesAreUniformWhereNothingIsThere) {
  int below = 0;
  constexpr int trials = 60;
  for (int i = 0; i < trials; ++i)
    below += test_of(slow_series(100 + 2 * i, 30.0), slow_series(101 + 2 * i, 30.0), 0.0).p_value <= 0.1 ? 1 : 0;
  // 6 expected; binomial, p < 0.002 for each
  EXPECT_LE(below, 14);
  EXPECT_GE(below, 1);
}

}  // namespace surrogates_test
}  // namespace gustlab::diagnosis
