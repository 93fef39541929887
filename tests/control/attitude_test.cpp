#include "control/attitude.hpp"

#include <gtest/gtest.h>

#include "gustlab/random.hpp"

namespace gustlab {
namespace attitude_test {

Quaternion random_attitude(std::uint64_t i) {
  const auto n = RandomStream(1, 0, "attitude_test").normal4(i);
  return Quaternion(n[0], n[1], n[2], n[3]).normalized();
}

TEST(EulerAngles, GoThereAndBack) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Quaternion q = random_attitude(i);
    EXPECT_LT(q.angularDistance(from_euler(euler_angles(q))), 1e-6);
  }
  const EulerAngles angles = euler_angles(from_euler({0.1, -0.2, 0.3}));
  EXPECT_NEAR(angles.roll_rad, 0.1, 1e-12);
  EXPECT_NEAR(angles.pitch_rad, -0.2, 1e-12);
  EXPECT_NEAR(angles.yaw_rad, 0.3, 1e-12);
}

TEST(AttitudeAlong, GivenAForceItsZAxisPointsThereAndItsNoseKeepsTheHeading) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    const auto n = RandomStream(1, 0, "force").normal4(i);
    const Vector3 force(n[0], n[1], std::abs(n[2]) + 0.1);
    const double yaw = n[3];
    const Quaternion q = attitude_along(force, yaw);
    EXPECT_LT((q * Vector3::UnitZ()).cross(force.normalized()).norm(), 1e-12);
    const Vector3 nose = q * Vector3::UnitX();
    // the nose has no component across the heading
    EXPECT_NEAR(nose.dot(Vector3(-std::sin(yaw), std::cos(yaw), 0.0)), 0.0, 1e-12);
    EXPECT_GT(nose.dot(Vector3(std::cos(yaw), std::sin(yaw), 0.0)), 0.0);
  }
}

TEST(AttitudeAlong, IsDefinedWhereTheForceIsNot) {
  EXPECT_TRUE(attitude_along(Vector3::Zero(), 0.0).isApprox(Quaternion::Identity()));
  EXPECT_TRUE(attitude_along(Vector3::UnitX(), 0.0).coeffs().allFinite());
}

TEST(TiltLimited, KeepsTheHeightAndTheDirection) {
  const Vector3 limited = tilt_limited({3.0, 4.0, 5.0}, pi / 6.0, 0.1);
  EXPECT_EQ(limited.z(), 5.0);
  EXPECT_NEAR(std::atan2(limited.head<2>().norm(), limited.z()), pi / 6.0, 1e-12);
  EXPECT_NEAR(limited.x() / limited.y(), 0.75, 1e-12);
  EXPECT_EQ(tilt_limited({0.1, 0.0, 5.0}, pi / 6.0, 0.1), Vector3(0.1, 0.0, 5.0));
  EXPECT_EQ(tilt_limited({0.0, 0.0, -5.0}, pi / 6.0, 0.1), Vector3(0.0, 0.0, 0.1));
}

TEST(AttitudeError, IsZeroAtTheTarget) {
  for (std::uint64_t i = 0; i < 50; ++i) {
    const Quaternion q = random_attitude(i);
    EXPECT_LT(attitude_error_B_rad(q, q, 0.4).norm(), 1e-7);
    EXPECT_LT(attitude_error_B_rad(q, Quaternion(-q.coeffs()), 0.4).norm(), 1e-7);
  }
}

// GIVEN any pair of attitudes WHEN the body turns along the error THEN it arrives, whatever the yaw weight
TEST(AttitudeError, LeadsThereFromEveryAttitude) {
  for (const double weight : {0.2, 0.5, 1.0})
    for (std::uint64_t i = 0; i < 200; ++i) {
      Quaternion q = random_attitude(2 * i);
      const Quaternion target = random_attitude(2 * i + 1);
      for (int step = 0; step < 4000; ++step) {
        const Vector3 error = attitude_error_B_rad(q, target, weight);
        const double angle = 0.01 * error.norm();
        if (angle > 0.0) q = (q * Quaternion(Eigen::AngleAxisd(angle, error.normalized()))).normalized();
      }
      EXPECT_LT(q.angularDistance(target), 2e-3) << "pair " << i << " weight " << weight;
    }
}

TEST(AttitudeError, PutsTheThrustDirectionRightBeforeTheHeading) {
  const Quaternion target = from_euler({0.0, 0.0, 2.5});
  const Vector3 error = attitude_error_B_rad(from_euler({0.3, 0.0, 0.0}), target, 0.2);
  EXPECT_NEAR(error.head<2>().norm(), 0.3, 1e-9);
  EXPECT_LT(std::abs(error.z()), 0.2 * 2.5 + 1e-9);
}

}  // namespace attitude_test
}  // namespace gustlab
