// A body whose centre of mass is not at its origin, and whose inertia is not diagonal, moves as Newton and Euler say.
#include <gmock/gmock.h>

#include "plant/plant.hpp"
#include "support/effects.hpp"

namespace gustlab::test {
namespace off_center_test {

TEST(OffCentre, PlantAcceleratesAsTheForceModelSays) {
  VehicleModel vehicle = small_quadrotor();
  vehicle.inertia_B_kgm2(0, 2) = vehicle.inertia_B_kgm2(2, 0) = 3e-6;
  vehicle.inertia_B_kgm2(0, 1) = vehicle.inertia_B_kgm2(1, 0) = -2e-6;
  constexpr double step_s = 1e-5;
  Plant plant(vehicle,
              make_effect_list(
                  {{"center_of_mass", {{"x", 0.003}, {"y", -0.004}, {"z", 0.002}}}, {"inertia", {{"delta_x", 0.1}}}}),
              {.step_s = step_s});
  VehicleState state;
  state.velocity_W_mps = {1.0, -2.0, 0.5};
  state.body_rate_B_radps = {5.0, -3.0, 4.0};
  state.attitude_WB = Eigen::AngleAxisd(0.8, Vector3(1, 2, 3).normalized());
  RotorCommand command{{1900, 2000, 2100, 1800}};
  state.rotor_speed_radps = command.speed_radps;
  plant.reset(state);

  const ForceModel& forces = plant.forces();
  Flow flow = forces.flow(state, 0.0);
  RotorSet rotors;
  forces.rotors(command.speed_radps, {}, flow, rotors);
  const Acceleration expected = forces.acceleration(flow, forces.wrench(flow, rotors, {}));
  ASSERT_TRUE(plant.step(command));
  const Vector3 linear = (forces.flow(plant.state(), 0.0).velocity_W_mps - flow.velocity_W_mps) / step_s;
  const Vector3 angular = (plant.state().body_rate_B_radps - state.body_rate_B_radps) / step_s;
  // first order in the step
  EXPECT_LT((linear - expected.linear_W_mps2).norm(), 1e-3 * expected.linear_W_mps2.norm());
  EXPECT_LT((angular - expected.angular_B_radps2).norm(), 1e-3 * expected.angular_B_radps2.norm());
}

}  // namespace off_center_test
}  // namespace gustlab::test
