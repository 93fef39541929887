// Position loops against their laws by hand.
#include "control/position_pid.hpp"

#include <gtest/gtest.h>

#include "control/attitude.hpp"
#include "support/vehicles.hpp"

namespace gustlab {
namespace position_pid_test {

constexpr double period_s = 0.01;

Reference at(const Vector3& position_W_m) {
  Reference reference;
  reference.position_W_m = position_W_m;
  return reference;
}

// one step from rest: P 2 on position, P 25 and I 1 (15) on velocity; degrees, and 1000 counts on 36000
TEST(CrazyfliePosition, IsTheFirmwaresCascade) {
  CrazyfliePosition loop(test::crazyflie(), {}, period_s);
  const ThrustAttitude wanted = loop.update({}, at({0.1, 0.2, 0.05}));
  const EulerAngles angles = euler_angles(wanted.attitude_WB);
  constexpr double degree = pi / 180.0;
  EXPECT_NEAR(angles.pitch_rad, (25.0 + period_s) * 0.2 * degree, 1e-9);
  EXPECT_NEAR(angles.roll_rad, -(25.0 + period_s) * 0.4 * degree, 1e-9);
  const double velocity = (2.0 + 0.5 * period_s) * 0.05;
  EXPECT_NEAR(
      wanted.thrust_N,
      LegacyMixer(test::crazyflie()).total_thrust_of_pwm(36000.0 + 1000.0 * (25.0 + 15.0 * period_s) * velocity), 1e-9);
}

// the same error ahead of the vehicle is the same pitch, wherever it looks
TEST(CrazyfliePosition, ThinksInTheHeadingOfTheVehicle) {
  for (const double yaw_rad : {0.0, 1.0, -2.5}) {
    CrazyfliePosition loop(test::crazyflie(), {}, period_s);
    Observation seen;
    seen.attitude_WB = from_euler({0.0, 0.0, yaw_rad});
    Reference reference = at(seen.attitude_WB * Vector3(0.2, 0.0, 0.0));
    reference.yaw_rad = yaw_rad;
    const EulerAngles angles = euler_angles(loop.update(seen, reference).attitude_WB);
    EXPECT_NEAR(angles.pitch_rad, (25.0 + period_s) * 0.4 * pi / 180.0, 1e-9) << yaw_rad;
    EXPECT_NEAR(angles.roll_rad, 0.0, 1e-9);
    EXPECT_NEAR(angles.yaw_rad, yaw_rad, 1e-9);
  }
}

TEST(CrazyfliePosition, KeepsItsLimits) {
  const LegacyMixer mixer(test::crazyflie());
  CrazyfliePosition loop(test::crazyflie(), {}, period_s);
  const ThrustAttitude far = loop.update({}, at({100.0, 0.0, -100.0}));
  EXPECT_NEAR(euler_angles(far.attitude_WB).pitch_rad, 20.0 * pi / 180.0, 1e-9);
  EXPECT_NEAR(far.thrust_N, mixer.total_thrust_of_pwm(20000.0), 1e-9);
  loop.reset();
  EXPECT_NEAR(loop.update({}, at(Vector3::Zero())).thrust_N, mixer.total_thrust_of_pwm(36000.0), 1e-9);
}

VehicleModel vehicle() { return test::ring(4, 1.5, 0.25, 0.0); }

TEST(ForcePosition, AsksForTheWeightWhereItShouldBe) {
  ForcePosition loop(vehicle(), {}, period_s);
  const ThrustAttitude wanted = loop.update({}, {});
  EXPECT_NEAR(wanted.thrust_N, vehicle().weight_N(), 1e-9);
  EXPECT_LT(wanted.attitude_WB.angularDistance(Quaternion::Identity()), 1e-9);
}

// without filters: v = P e, a = P (v − v_now) + I ∫, and the first step has no derivative
TEST(ForcePosition, IsPOnPositionAndPIOnVelocity) {
  ForcePosition::Options options;
  options.error_cutoff_hz = options.derivative_cutoff_hz = 0.0;
  ForcePosition loop(vehicle(), options, period_s);
  Reference reference = at({0.2, 0.0, 0.1});
  reference.velocity_W_mps = {0.0, 0.1, 0.0};
  reference.acceleration_W_mps2 = {0.0, 0.0, 0.4};
  const ThrustAttitude wanted = loop.update({}, reference);
  const Vector3 acceleration((2.0 + period_s) * 0.2, (2.0 + period_s) * 0.1, (5.0 + 2.5 * period_s) * 0.1 + 0.4);
  const Vector3 force = vehicle().mass_kg * (acceleration + 9.81 * Vector3::UnitZ());
  EXPECT_NEAR(wanted.thrust_N, force.z(), 1e-9);
  EXPECT_LT((wanted.attitude_WB * Vector3::UnitZ() - force.normalized()).norm(), 1e-9);
}

// far away the speed is the limit's, along the error
TEST(ForcePosition, FliesStraightAtItsSpeedLimitFromFarAway) {
  ForcePosition::Options options;
  options.error_cutoff_hz = options.derivative_cutoff_hz = 0.0;
  options.velocity_limit_xy_mps = 2.0;
  options.tilt_limit_rad = 1.2;
  ForcePosition loop(vehicle(), options, period_s);
  const Vector3 thrust_axis = loop.update({}, at({300.0, 400.0, 0.0})).attitude_WB * Vector3::UnitZ();
  const Vector3 force = (2.0 + period_s) * 2.0 * Vector3(0.6, 0.8, 0.0) + 9.81 * Vector3::UnitZ();
  EXPECT_LT((thrust_axis - force.normalized()).norm(), 1e-9);
}

// at the tilt limit nothing more is integrated: back at the goal the vehicle is level at once
TEST(ForcePosition, DoesNotWindUpAtTheTiltLimit) {
  ForcePosition::Options options;
  options.error_cutoff_hz = options.derivative_cutoff_hz = 0.0;
  options.tilt_limit_rad = 0.1;
  ForcePosition loop(vehicle(), options, period_s);
  for (int k = 0; k < 300; ++k) {
    const Vector3 axis = loop.update({}, at({50.0, 0.0, 0.0})).attitude_WB * Vector3::UnitZ();
    EXPECT_NEAR(std::atan2(axis.x(), axis.z()), 0.1, 1e-9);
  }
  loop.update({}, {});
  EXPECT_LT((loop.update({}, {}).attitude_WB * Vector3::UnitZ()).head<2>().norm(), 1e-9);
}

// f / cos(tilt) up to 60 degrees, less from there, nothing beyond 90
TEST(ForcePosition, BoostsThrustByTheTilt) {
  for (const auto& [tilt_rad, boost] :
       {std::pair{0.5, 1.0 / std::cos(0.5)}, {pi / 3.0, 2.0}, {1.3, 4.0 * std::cos(1.3)}, {2.0, 0.0}}) {
    ForcePosition loop(vehicle(), {}, period_s);
    Observation seen;
    seen.attitude_WB = from_euler({tilt_rad, 0.0, 0.0});
    EXPECT_NEAR(loop.update(seen, {}).thrust_N, boost * vehicle().weight_N(), 1e-6) << tilt_rad;
  }
}

}  // namespace position_pid_test
}  // namespace gustlab
