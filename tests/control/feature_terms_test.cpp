#include "control/feature_terms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace feature_terms_test {

FeatureInput some_input() {
  FeatureInput in;
  in.position_W_m = {1.0, -2.0, 3.0};
  in.velocity_W_mps = {0.5, -0.25, 2.0};
  in.roll_rad = 0.3;
  in.pitch_rad = -0.2;
  in.yaw_rad = 1.1;
  in.thrust_N = 19.4;
  in.body_rate_B_radps = {0.1, 0.2, -0.3};
  return in;
}

double value(const char* text) { return FeatureTerm::parse(text).value(some_input()); }

TEST(FeatureTerm, ThePapersSevenHaveTheirMeaning) {
  EXPECT_DOUBLE_EQ(value("1"), 1.0);
  EXPECT_DOUBLE_EQ(value("theta"), -0.2);
  EXPECT_DOUBLE_EQ(value("phi"), 0.3);
  EXPECT_DOUBLE_EQ(value("T sin theta"), 19.4 * std::sin(-0.2));
  EXPECT_DOUBLE_EQ(value("T cos theta"), 19.4 * std::cos(-0.2));
  EXPECT_DOUBLE_EQ(value("T sin phi"), 19.4 * std::sin(0.3));
  EXPECT_DOUBLE_EQ(value("T cos phi"), 19.4 * std::cos(0.3));
}

TEST(FeatureTerm, ProductsPowersMultiplesAndFunctions) {
  EXPECT_DOUBLE_EQ(value("vx^2 vy"), 0.25 * -0.25);
  EXPECT_DOUBLE_EQ(value("vx*abs(vx)"), 0.25);
  EXPECT_DOUBLE_EQ(value("sin 2 psi"), std::sin(2.2));
  EXPECT_DOUBLE_EQ(value("cos(3 psi)"), std::cos(3.0 * 1.1));
  EXPECT_DOUBLE_EQ(value("sin theta^2"), std::pow(std::sin(-0.2), 2));
  EXPECT_DOUBLE_EQ(value("speed"), std::sqrt(0.25 + 0.0625 + 4.0));
}

TEST(FeatureTerm, OneNamePerTermAndItReadsBack) {
  EXPECT_EQ(FeatureTerm::parse("  T*sin( theta ) ").name(), "T sin theta");
  EXPECT_EQ(FeatureTerm::parse(" 1 ").name(), "1");
  EXPECT_EQ(FeatureTerm::parse("sin(1 psi)").name(), "sin psi");
  for (const char* text : {"1", "T sin theta", "vx^2 vy", "abs vx cos 2 psi^3"}) {
    const FeatureTerm term = FeatureTerm::parse(text);
    EXPECT_EQ(term.name(), text);
    EXPECT_EQ(FeatureTerm::parse(term.name()).value(some_input()), term.value(some_input()));
  }
}

TEST(FeatureTerm, EveryVariableIsFiniteAndCanBeNamed) {
  for (const FeatureVariable& variable : feature_variables()) {
    EXPECT_EQ(value(std::string(variable.name).c_str()), variable.value(some_input())) << variable.name;
    EXPECT_TRUE(std::isfinite(variable.value(some_input()))) << variable.name;
    EXPECT_FALSE(variable.unit.empty() || variable.says.empty()) << variable.name;
  }
}

TEST(FeatureTerm, WhatIsNotATermIsRefused) {
  for (const char* text : {"", " ", "thta", "T sin", "sin", "T *", "vx^", "vx^0", "vx^10", "sin(theta", "2", "1 vx",
                           "vx;vy", "vx vx vx vx vx", "sin 0 psi", "sin 12 psi"}) {
    EXPECT_THROW(FeatureTerm::parse(text), ConfigError) << '`' << text << '`';
  }
}

TEST(SetAngles, RecoversTheAnglesThatMadeTheRotation) {
  for (double roll : {-2.0, 0.0, 0.4}) {
    for (double pitch : {-1.2, 0.0, 0.7}) {
      for (double yaw : {-3.0, 0.0, 1.5}) {
        const Quaternion q = Eigen::AngleAxisd(yaw, Vector3::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3::UnitY()) *
                             Eigen::AngleAxisd(roll, Vector3::UnitX());
        FeatureInput in = some_input();
        set_angles(in, q.toRotationMatrix());
        EXPECT_NEAR(in.roll_rad, roll, 1e-12);
        EXPECT_NEAR(in.pitch_rad, pitch, 1e-12);
        EXPECT_NEAR(in.yaw_rad, yaw, 1e-12);
        // velocity in body axes agrees with the rotation itself
        const Vector3 velocity_B = q.conjugate() * in.velocity_W_mps;
        EXPECT_NEAR(FeatureTerm::parse("vx_B").value(in), velocity_B.x(), 1e-12);
        EXPECT_NEAR(FeatureTerm::parse("vy_B").value(in), velocity_B.y(), 1e-12);
        EXPECT_NEAR(FeatureTerm::parse("vz_B").value(in), velocity_B.z(), 1e-12);
      }
    }
  }
}

TEST(Evaluate, FillsInOrder) {
  const std::vector<FeatureTerm> terms = {FeatureTerm::parse("1"), FeatureTerm::parse("px"), FeatureTerm::parse("T")};
  double out[3];
  evaluate(terms, some_input(), out);
  EXPECT_EQ(out[0], 1.0);
  EXPECT_EQ(out[1], 1.0);
  EXPECT_EQ(out[2], 19.4);
}

}  // namespace feature_terms_test
}  // namespace gustlab
