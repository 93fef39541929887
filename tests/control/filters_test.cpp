#include "control/filters.hpp"

#include <gtest/gtest.h>

#include "control/pid.hpp"

namespace gustlab {
namespace filters_test {

double gain_at(double cutoff_hz, double frequency_hz) {
  const double period_s = 0.002;
  LowPass2<double> filter(cutoff_hz, period_s, 0.0);
  double most = 0.0;
  const int steps = 5000;
  for (int i = 0; i < steps; ++i) {
    const double out = filter.update(std::sin(2.0 * pi * frequency_hz * i * period_s));
    if (i > steps / 2) most = std::max(most, std::abs(out));
  }
  return most;
}

TEST(LowPass2, IsAButterworthFilter) {
  // |H|² = 1/(1 + (tan(πfT)/tan(πf_cT))⁴) after the bilinear transform
  EXPECT_NEAR(gain_at(8.0, 0.1), 1.0, 1e-4);
  EXPECT_NEAR(gain_at(8.0, 8.0), std::sqrt(0.5), 1e-3);
  const double ratio = std::tan(pi * 40.0 * 0.002) / std::tan(pi * 8.0 * 0.002);
  EXPECT_NEAR(gain_at(8.0, 40.0), 1.0 / std::sqrt(1.0 + std::pow(ratio, 4)), 1e-3);
}

TEST(LowPass2, StartsSettledAndKeepsAConstant) {
  LowPass2<Vector3> filter(8.0, 0.002, Vector3(1.0, -2.0, 3.0));
  for (int i = 0; i < 100; ++i)
    EXPECT_LT((filter.update(Vector3(1.0, -2.0, 3.0)) - Vector3(1.0, -2.0, 3.0)).norm(), 1e-12);
}

TEST(LowPass2, WithoutACutoffChangesNothing) {
  LowPass2<double> filter(0.0, 0.002, 0.0);
  EXPECT_EQ(filter.update(3.7), 3.7);
  LowPass2<double> above(300.0, 0.002, 0.0);
  EXPECT_EQ(above.update(3.7), 3.7);
}

TEST(LowPass1, FollowsAStepExactly) {
  LowPass1<double> filter(0.1, 0.01, 0.0);
  double value = 0.0;
  for (int i = 0; i < 10; ++i) value = filter.update(1.0);
  EXPECT_NEAR(value, 1.0 - std::exp(-1.0), 1e-12);
}

TEST(Filters, LetANanThrough) {
  LowPass1<double> first(0.1, 0.01, 0.0);
  LowPass2<double> second(8.0, 0.002, 0.0);
  EXPECT_TRUE(std::isnan(first.update(std::nan(""))));
  EXPECT_TRUE(std::isnan(second.update(std::nan(""))));
  EXPECT_TRUE(std::isnan(first.update(1.0)));
  EXPECT_TRUE(std::isnan(second.update(1.0)));
  EXPECT_TRUE(std::isnan(limited(std::nan(""), 1.0)));
  EXPECT_TRUE(std::isnan(limited(Vector3(0.0, std::nan(""), 0.0), Vector3::Ones()).y()));
}

TEST(Pid, GivenNoErrorGivesNothing) {
  Pid pid({Vector3::Ones(), Vector3::Ones(), Vector3::Ones()});
  EXPECT_EQ(pid.update(Vector3::Zero(), Vector3::Zero(), 0.01), Vector3::Zero());
}

TEST(Pid, GivenALastingErrorItsIntegralStopsAtItsLimit) {
  Pid pid({Vector3::Zero(), 2.0 * Vector3::Ones(), Vector3::Zero(), 0.5 * Vector3::Ones()});
  for (int i = 0; i < 1000; ++i) pid.update(Vector3::Ones(), Vector3::Zero(), 0.01);
  EXPECT_EQ(pid.update(Vector3::Ones(), Vector3::Zero(), 0.01), Vector3::Ones());
}

TEST(SquareRootLaw, IsSmoothAndStopsInTime) {
  const double p = 2.0, a = 3.0, joint = a / (p * p);
  EXPECT_NEAR(square_root_law(joint - 1e-9, p, a), square_root_law(joint + 1e-9, p, a), 1e-7);
  EXPECT_EQ(square_root_law(0.1, p, a), 0.2);
  EXPECT_EQ(square_root_law(-0.1, p, a), -0.2);
  // v dv/de = a beyond the joint: a constant deceleration
  const double e = 5.0, h = 1e-5;
  const double slope = (square_root_law(e + h, p, a) - square_root_law(e - h, p, a)) / (2 * h);
  EXPECT_NEAR(square_root_law(e, p, a) * slope, a, 1e-6);
  EXPECT_EQ(square_root_law(-e, p, a), -square_root_law(e, p, a));
}

}  // namespace filters_test
}  // namespace gustlab
