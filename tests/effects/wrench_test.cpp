// Closed forms of the effects that add a force or a torque.
#include "effects/instant.hpp"

namespace gustlab::test {
namespace wrench_test {

const Vector3 e3 = Vector3::UnitZ();

TEST(RotorDrag, PullsAtEachHubAgainstItsInPlaneMotion) {
  const Instant now;
  const double per_speed = 0.02 / (4 * now.vehicle.hover_speed_radps());
  Vector3 force = Vector3::Zero(), torque = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    Vector3 velocity = now.hub_velocity_B(i);
    velocity.z() = 0.0;
    const Vector3 f = -per_speed * now.speed_radps[i] * velocity;
    force += f;
    torque += now.hub_B(i).cross(f);
  }
  const Wrench added = now.added({{"rotor_drag", {{"at_hover", 0.02}}}});
  expect_near(added.force_B_N, force);
  expect_near(added.torque_B_Nm, torque);
}

TEST(RotorDrag, IsItsNameAtHoverAndDampsYaw) {
  Instant now;
  now.vehicle.center_of_mass_B_m = {0.0, 0.0, 0.021};  // in the plane of the hubs
  now.speed_radps.fill(now.vehicle.hover_speed_radps());
  now.state.attitude_WB.setIdentity();
  now.state.velocity_W_mps = {2.0, 0.0, 1.0};
  now.state.body_rate_B_radps = {0.0, 0.0, 3.0};
  const Wrench added = now.added({{"rotor_drag", {{"at_hover", 0.02}}}});
  expect_near(added.force_B_N, {-0.04, 0.0, 0.0});
  expect_near(added.torque_B_Nm, {0.0, 0.0, -0.02 * 3.0 * (2 * 0.031 * 0.031)});
}

TEST(QuadraticDrag, IsHalfDensityAreaSpeedSquared) {
  const Instant now;
  const Vector3 v = now.air_velocity_B();
  const Wrench added = now.added({{"quadratic_drag", {{"area_xy", 0.01}, {"area_z", 0.03}}}});
  expect_near(added.force_B_N, -0.5 * 1.225 * v.norm() * Vector3(0.01 * v.x(), 0.01 * v.y(), 0.03 * v.z()));
  EXPECT_EQ(added.torque_B_Nm, Vector3::Zero());
}

TEST(FlappingTorque, TurnsTheNoseUpWhenMovingForward) {
  const Instant now;
  Vector3 torque = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i) torque += 2e-7 * now.speed_radps[i] * now.hub_velocity_B(i).cross(e3);
  expect_near(now.added({{"flapping_torque", {{"coefficient", 2e-7}}}}).torque_B_Nm, torque, 1e-8);

  Instant forward;
  forward.state.attitude_WB.setIdentity();
  forward.state.body_rate_B_radps.setZero();
  forward.state.velocity_W_mps = {3.0, 0.0, 0.0};
  const Wrench added = forward.added({{"flapping_torque", {{"coefficient", 2e-7}}}});
  // a positive turn about y (left) takes x to −z: nose down
  EXPECT_LT(added.torque_B_Nm.y(), 0.0);
  EXPECT_EQ(added.force_B_N, Vector3::Zero());
}

TEST(WallEffect, DrawsTowardEveryWallWithTheInverseSquare) {
  const Instant now;
  double thrust = 0.0;
  for (std::size_t i = 0; i < 4; ++i) thrust += now.nominal_thrust_N(i);
  const double radius = now.vehicle.rotor_radius_m;
  const auto pull = [&](double distance) { return 0.03 * thrust * radius * radius / (distance * distance); };
  const Wrench added = now.added({{"wall_effect", {{"strength", 0.03}}}});
  // walls: x = 1 (0.6 m ahead of x = 0.4) and y = −0.5 (0.2 m below y = −0.3)
  expect_near(now.R() * added.force_B_N, {pull(0.6), -pull(0.2), 0.0});
}

TEST(WallEffect, SaturatesOneRadiusFromTheWall) {
  Instant now;
  now.vehicle.environment.walls = {{{1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}}};
  now.state.position_W_m.x() = 0.999;
  double thrust = 0.0;
  for (std::size_t i = 0; i < 4; ++i) thrust += now.nominal_thrust_N(i);
  expect_near(now.R() * now.added({{"wall_effect", {{"strength", 0.03}}}}).force_B_N, {0.03 * thrust, 0.0, 0.0});
}

TEST(SteadyWind, ActsOnlyThroughTheAirAndAsMotionTheOtherWay) {
  const Instant now;
  const Values wind = {{"x", 2.0}, {"y", -1.0}, {"z", 0.5}};
  const Wrench alone = now.added({{"steady_wind", wind}});
  EXPECT_EQ(alone.force_B_N, Vector3::Zero());
  EXPECT_EQ(alone.torque_B_Nm, Vector3::Zero());

  const std::vector<Wanted> air = {{"rotor_drag", {{"at_hover", 0.02}}},
                                   {"quadratic_drag", {{"area_xy", 0.01}}},
                                   {"axial_inflow", {{"at_hover", 0.01}}},
                                   {"translational_lift", {{"coefficient", 3e-4}}},
                                   {"flapping_torque", {{"coefficient", 1e-7}}}};
  std::vector<Wanted> windy = air;
  windy.push_back({"steady_wind", wind});
  Instant upwind = now;
  upwind.state.velocity_W_mps -= Vector3(2.0, -1.0, 0.5);
  const Wrench blown = now.evaluate(windy).wrench, moved = upwind.evaluate(air).wrench;
  expect_near(blown.force_B_N, moved.force_B_N);
  expect_near(blown.torque_B_Nm, moved.torque_B_Nm);
}

TEST(ConstantForce, IsFixedInTheWorldAtTheCentreOfMass) {
  const Instant now;
  const Wrench added = now.added({{"constant_force", {{"x", 0.01}, {"y", -0.02}, {"z", 0.03}}}});
  expect_near(now.R() * added.force_B_N, {0.01, -0.02, 0.03});
  EXPECT_EQ(added.torque_B_Nm, Vector3::Zero());
}

TEST(RotorInertia, ReactsToSpeedingUpAndTurningOfTheSpin) {
  const Instant now;
  const double I = 3e-8;
  double spin_up = 0.0, spin = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    spin_up += now.vehicle.rotors[i].direction * I * now.acceleration_radps2[i];
    spin += now.vehicle.rotors[i].direction * I * now.speed_radps[i];
  }
  const Wrench added = now.added({{"rotor_inertia", {{"inertia", I}}}});
  expect_near(added.torque_B_Nm, -spin_up * e3 - now.state.body_rate_B_radps.cross(spin * e3), 1e-8);
  EXPECT_EQ(added.force_B_N, Vector3::Zero());
}

TEST(RotorInertia, SpeedingUpACounterClockwiseRotorTurnsTheVehicleClockwise) {
  Instant now;
  now.state.body_rate_B_radps.setZero();
  now.acceleration_radps2 = {500, 0, 0, 0};  // the first turns counter-clockwise
  EXPECT_LT(now.added({{"rotor_inertia", {{"inertia", 3e-8}}}}).torque_B_Nm.z(), 0.0);
}

}  // namespace wrench_test
}  // namespace gustlab::test
