// One rigid body against Newton and Euler, and its resistance against their formulas.
#include "plant/rigid_body.hpp"

#include <gmock/gmock.h>

#include "gustlab/errors.hpp"
#include "plant/bias_force.hpp"
#include "support/vehicles.hpp"

namespace gustlab {
namespace rigid_body_test {

using ::testing::HasSubstr;

VehicleModel odd_vehicle() {
  VehicleModel vehicle = test::ring(4, 1.5, 0.25, 0.0);
  vehicle.inertia_B_kgm2 << 0.02, 0.001, -0.002, 0.001, 0.03, 0.0015, -0.002, 0.0015, 0.04;
  vehicle.center_of_mass_B_m = {0.03, -0.02, 0.01};
  return vehicle;
}

VehicleState some_state() {
  VehicleState state;
  state.position_W_m = {1.0, 2.0, 30.0};
  state.velocity_W_mps = {0.5, -1.0, 2.0};
  state.attitude_WB = Quaternion(Eigen::AngleAxisd(0.8, Vector3(1.0, -2.0, 0.5).normalized()));
  state.body_rate_B_radps = {3.0, -2.0, 1.0};
  return state;
}

Flow flow_of(const VehicleState& state, const VehicleModel& vehicle) {
  Flow flow;
  flow.R_WB = state.attitude_WB.toRotationMatrix();
  flow.velocity_W_mps = state.velocity_W_mps + flow.R_WB * state.body_rate_B_radps.cross(vehicle.center_of_mass_B_m);
  return flow;
}

Vector3 center(const VehicleState& state, const VehicleModel& vehicle) {
  return state.position_W_m + state.attitude_WB * vehicle.center_of_mass_B_m;
}

// of one small step: m a = R f + m g, I dω/dt = τ − ω × I ω, about the centre of mass
TEST(RigidBody, AcceleratesAsNewtonAndEulerHaveIt) {
  const VehicleModel vehicle = odd_vehicle();
  constexpr double step_s = 1e-6;
  RigidBody body(vehicle, step_s);
  const VehicleState before = some_state();
  VehicleState after = before;
  const Wrench wrench{{0.3, -0.2, 20.0}, {0.01, 0.02, -0.015}};
  ASSERT_TRUE(body.step(flow_of(before, vehicle), wrench, after));
  const Vector3& w = before.body_rate_B_radps;
  const Vector3 linear = before.attitude_WB * wrench.force_B_N / vehicle.mass_kg - 9.81 * Vector3::UnitZ();
  const Vector3 angular = vehicle.inertia_B_kgm2.inverse() * (wrench.torque_B_Nm - w.cross(vehicle.inertia_B_kgm2 * w));
  const Vector3 moved = (flow_of(after, vehicle).velocity_W_mps - flow_of(before, vehicle).velocity_W_mps) / step_s;
  EXPECT_LT((moved - linear).norm(), 1e-6 * linear.norm());
  EXPECT_LT(((after.body_rate_B_radps - w) / step_s - angular).norm(), 1e-5 * angular.norm());
  const Vector3 drifted = (center(after, vehicle) - center(before, vehicle)) / step_s;
  EXPECT_LT((drifted - flow_of(after, vehicle).velocity_W_mps).norm(), 1e-6);
  const Quaternion turned = before.attitude_WB.conjugate() * after.attitude_WB;
  EXPECT_LT((2.0 * turned.vec() / step_s - after.body_rate_B_radps).norm(), 1e-6);
  EXPECT_EQ(body.contacts(), 0);
}

TEST(RigidBody, SaysWhenANumberIsNotFinite) {
  const VehicleModel vehicle = odd_vehicle();
  RigidBody body(vehicle, 0.002);
  VehicleState state = some_state();
  EXPECT_FALSE(body.step(flow_of(state, vehicle), {{std::nan(""), 0.0, 0.0}, Vector3::Zero()}, state));
  // and forgets it
  body.forget();
  state = some_state();
  EXPECT_TRUE(body.step(flow_of(state, vehicle), {}, state));
}

TEST(RigidBody, RefusesAVehicleWithoutMassOrInertia) {
  for (const bool mass : {true, false}) {
    VehicleModel vehicle = odd_vehicle();
    vehicle.source_path = "light.toml";
    if (mass) vehicle.mass_kg = -0.1;
    else vehicle.inertia_B_kgm2(1, 1) = 0.0;
    try {
      RigidBody body(vehicle, 0.002);
      FAIL() << "accepted";
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.exit_code(), 2);
      EXPECT_THAT(error.what(), HasSubstr("light.toml: mass"));
    }
  }
}

TEST(BiasForce, IsTheWeightAndTheTorqueOfTheTurning) {
  const FreeBody body{1.7, {0.02, 0.03, 0.05}, 9.81};
  const VehicleState state = some_state();
  const Vector3& w = state.body_rate_B_radps;
  const BiasForce bias =
      bias_force(body, state.position_W_m, state.attitude_WB.toRotationMatrix(), state.velocity_W_mps, w);
  EXPECT_LT((bias.force_W_N - Vector3(0.0, 0.0, 1.7 * 9.81)).norm(), 1e-12);
  EXPECT_LT((bias.torque_B_Nm - w.cross(body.inertia_kgm2.cwiseProduct(w))).norm(), 1e-12);
}

}  // namespace rigid_body_test
}  // namespace gustlab
