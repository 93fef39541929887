// The plant against closed forms. MuJoCo's semi-implicit Euler is of first order, so limits scale with the step.
#include <gmock/gmock.h>

#include <cmath>

#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {
namespace closed_forms_test {

Plant make_plant(const VehicleModel& vehicle, const std::vector<EffectSpec>& effects, double step_s) {
  return Plant(vehicle, make_effects(effects), {.step_s = step_s, .seed = 1, .replicate = 1});
}

void run(Plant& plant, const RotorCommand& command, double duration_s) {
  const auto steps = static_cast<int>(std::lround(duration_s / plant.step_s()));
  for (int i = 0; i < steps; ++i) ASSERT_TRUE(plant.step(command));
}

// rotor speeds at which thrusts and torques balance about the centre of mass
RotorCommand trim(const VehicleModel& vehicle) {
  Eigen::Matrix4d allocation;
  for (int i = 0; i < 4; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    const Vector3 torque = (rotor.position_B_m - vehicle.center_of_mass_B_m).cross(rotor.axis_B) -
                           rotor.direction * rotor.torque_ratio_m * rotor.axis_B;
    allocation.col(i) << rotor.axis_B.z(), torque;
  }
  const Eigen::Vector4d thrust = allocation.inverse() * Eigen::Vector4d(vehicle.weight_N(), 0.0, 0.0, 0.0);
  RotorCommand command;
  for (std::size_t i = 0; i < 4; ++i)
    command.speed_radps[i] = std::sqrt(thrust[static_cast<int>(i)] / vehicle.rotors[i].thrust_coefficient_Ns2);
  return command;
}

TEST(Plant, FallsFreelyAsEveryBodyDoes) {
  for (const std::string& name : vehicle_names()) {
    Plant plant = make_plant(read_vehicle(name), {}, 0.001);
    VehicleState state;
    state.velocity_W_mps = Vector3(1.0, -2.0, 0.0);
    plant.reset(state);
    run(plant, {}, 1.0);
    // semi-implicit Euler sums g dt² (1 + 2 + … + n)
    EXPECT_NEAR(plant.state().position_W_m.z(), -9.81 * 1e-6 * 1000.0 * 1001.0 / 2.0, 1e-10) << name;
    EXPECT_NEAR(plant.state().position_W_m.x(), 1.0, 1e-10);
    EXPECT_NEAR(plant.state().velocity_W_mps.z(), -9.81, 1e-10);
    EXPECT_EQ(plant.state().time_s, 1.0);
  }
}

TEST(Plant, HoversAtTrimWhereverTheCentreOfMassIs) {
  for (const char* name : {"iris", "crazyflie", "crazyflie_brushless"}) {
    const VehicleModel vehicle = read_vehicle(name);
    const RotorCommand command = trim(vehicle);
    Plant plant = make_plant(vehicle, vehicle.effects, 0.002);
    VehicleState state;
    state.rotor_speed_radps = command.speed_radps;
    plant.reset(state);
    run(plant, command, 2.0);
    EXPECT_LT(plant.state().position_W_m.norm(), 1e-6) << name;
    EXPECT_LT(plant.state().velocity_W_mps.norm(), 1e-6) << name;
    EXPECT_LT(plant.state().body_rate_B_radps.norm(), 1e-6) << name;
    const Observation seen = plant.observe(true);
    EXPECT_NEAR(seen.specific_force_B_mps2.z(), 9.81, 1e-6) << name;
  }
}

TEST(Plant, ReachesTheTerminalVelocityOfQuadraticDrag) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  constexpr double area_m2 = 0.01;
  Plant plant = make_plant(vehicle, {{"quadratic_drag", {{"area_xy", "0.01"}, {"area_z", "0.01"}}, "test", {}}}, 0.001);
  const double terminal_mps = std::sqrt(2.0 * vehicle.weight_N() / (air_density_kgpm3 * area_m2));
  plant.reset({});
  run(plant, {}, 0.5);
  EXPECT_NEAR(plant.state().velocity_W_mps.z(), -terminal_mps * std::tanh(9.81 * 0.5 / terminal_mps), 5e-3);
  run(plant, {}, 6.0);
  EXPECT_NEAR(plant.state().velocity_W_mps.z(), -terminal_mps, 1e-6 * terminal_mps);
}

TEST(Plant, SlowsDownExponentiallyByRotorDrag) {
  VehicleModel vehicle = read_vehicle("crazyflie");
  for (Rotor& rotor : vehicle.rotors) rotor.position_B_m.z() = vehicle.center_of_mass_B_m.z();
  Plant plant = make_plant(vehicle, {{"rotor_drag", {{"at_hover", "0.02"}}, "test", {}}}, 0.001);
  VehicleState state;
  state.velocity_W_mps.x() = 2.0;
  state.rotor_speed_radps.fill(0.0);
  RotorCommand hover;
  for (std::size_t i = 0; i < 4; ++i) hover.speed_radps[i] = state.rotor_speed_radps[i] = vehicle.hover_speed_radps();
  plant.reset(state);
  run(plant, hover, 1.0);
  EXPECT_NEAR(plant.state().velocity_W_mps.x(), 2.0 * std::exp(-0.02 / vehicle.mass_kg), 2e-3);
}

TEST(Plant, PrecessesFreelyAsASymmetricTopDoes) {
  VehicleModel vehicle = read_vehicle("crazyflie");
  vehicle.inertia_B_kgm2 = Vector3(2e-5, 2e-5, 3.5e-5).asDiagonal();
  vehicle.center_of_mass_B_m.setZero();
  Plant plant = make_plant(vehicle, {}, 1e-4);
  VehicleState state;
  state.body_rate_B_radps = Vector3(1.0, 0.0, 4.0);
  plant.reset(state);
  const Vector3 momentum = vehicle.inertia_B_kgm2 * state.body_rate_B_radps;
  run(plant, {}, 1.0);
  // ω turns about the axis of symmetry with (J_zz − J_xx) / J_xx ω_z
  const double turn = 0.75 * 4.0;
  const Vector3 expected(std::cos(turn), std::sin(turn), 4.0);
  EXPECT_LT((plant.state().body_rate_B_radps - expected).norm(), 2e-3);
  EXPECT_LT((plant.state().attitude_WB * (vehicle.inertia_B_kgm2 * plant.state().body_rate_B_radps) - momentum).norm(),
            2e-3 * momentum.norm());
}

TEST(Plant, TumblesAboutItsCentreOfMass) {
  VehicleModel vehicle = read_vehicle("crazyflie");
  vehicle.center_of_mass_B_m = Vector3(0.02, -0.01, 0.005);
  Plant plant = make_plant(vehicle, {}, 0.001);
  VehicleState state;
  state.body_rate_B_radps = Vector3(3.0, -5.0, 8.0);
  plant.reset(state);
  const auto center_W_m = [&]() -> Vector3 {
    return plant.state().position_W_m + plant.state().attitude_WB * vehicle.center_of_mass_B_m;
  };
  const Vector3 start_W_m = center_W_m(), velocity_W_mps = state.body_rate_B_radps.cross(vehicle.center_of_mass_B_m);
  run(plant, {}, 1.0);
  const Vector3 fall_W_m(0.0, 0.0, -9.81 * 1e-6 * 1000.0 * 1001.0 / 2.0);
  EXPECT_LT((center_W_m() - (start_W_m + velocity_W_mps + fall_W_m)).norm(), 1e-10);
}

TEST(Plant, RotorsFollowTheirLagExactlyAtAnyStep) {
  VehicleModel vehicle = read_vehicle("crazyflie");
  const std::vector<EffectSpec> lag{
      {"motor_lag", {{"time_constant", "0.05"}, {"time_constant_down", "0.1"}}, "test", {}}};
  for (const double step_s : {0.001, 0.01}) {
    Plant plant = make_plant(vehicle, lag, step_s);
    plant.reset({});
    RotorCommand command;
    command.speed_radps.fill(2000.0);
    run(plant, command, 0.2);
    const double risen = 2000.0 * (1.0 - std::exp(-0.2 / 0.05));
    EXPECT_NEAR(plant.state().rotor_speed_radps[0], risen, 1e-9);
    command.speed_radps.fill(500.0);
    run(plant, command, 0.2);
    EXPECT_NEAR(plant.state().rotor_speed_radps[3], 500.0 + (risen - 500.0) * std::exp(-0.2 / 0.1), 1e-9);
  }
}

TEST(Plant, CommandsBeyondTheMotorsAreClipped) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  Plant plant = make_plant(vehicle, {}, 0.001);
  plant.reset({});
  RotorCommand command;
  command.speed_radps = {1e6, -5.0, 100.0, 100.0};
  ASSERT_TRUE(plant.step(command));
  EXPECT_EQ(plant.state().rotor_speed_radps[0], vehicle.max_speed_radps);
  EXPECT_EQ(plant.state().rotor_speed_radps[1], 0.0);
}

}  // namespace closed_forms_test
}  // namespace gustlab
