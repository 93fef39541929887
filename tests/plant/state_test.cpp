// Snapshots, divergence, the ground, and MuJoCo's traps.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "support/temporary_folder.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {
namespace state_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Plant make_plant(const VehicleModel& vehicle, const std::vector<EffectSpec>& effects) {
  return Plant(vehicle, make_effects(effects), {.step_s = 0.002, .seed = 7, .replicate = 3});
}

RotorCommand shaken(const VehicleModel& vehicle, int step) {
  RotorCommand command;
  for (std::size_t i = 0; i < 4; ++i)
    command.speed_radps[i] = vehicle.hover_speed_radps() * (1.0 + 0.05 * std::sin(0.1 * step + static_cast<double>(i)));
  return command;
}

// everything that is observable, as numbers
std::vector<double> seen(Plant& plant) {
  const VehicleState& s = plant.state();
  const Observation o = plant.observe(true);
  std::vector<double> all{s.time_s, plant.steps() * 1.0};
  for (const Vector3& v : {s.position_W_m, s.velocity_W_mps, s.body_rate_B_radps, o.position_W_m, o.velocity_W_mps,
                           o.specific_force_B_mps2})
    all.insert(all.end(), v.begin(), v.end());
  for (const Quaternion& q : {s.attitude_WB, o.attitude_WB})
    all.insert(all.end(), q.coeffs().begin(), q.coeffs().end());
  all.insert(all.end(), s.rotor_speed_radps.begin(), s.rotor_speed_radps.end());
  return all;
}

TEST(Snapshot, CarriesEverythingThatTheFutureDependsOn) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  const std::vector<EffectSpec> effects{{"gust", {{"sigma_xy", "0.02"}, {"correlation_time", "0.5"}}, "test", {}},
                                        {"actuation_delay", {{"delay", "0.0125"}}, "test", {}},
                                        {"motor_lag", {{"time_constant", "0.05"}}, "test", {}},
                                        {"pose_delay", {{"delay", "0.0105"}}, "test", {}},
                                        {"slung_load", {{"mass", "0.003"}, {"length", "0.3"}}, "test", {}},
                                        {"measurement_noise", {}, "test", {}}};
  Plant plant = make_plant(vehicle, effects);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(plant.step(shaken(vehicle, i)));
    plant.observe(false);
  }
  const std::vector<double> snapshot = plant.snapshot();
  std::vector<std::vector<double>> first;
  for (int i = 100; i < 200; ++i) {
    ASSERT_TRUE(plant.step(shaken(vehicle, i)));
    first.push_back(seen(plant));
  }
  Plant other = make_plant(vehicle, effects);
  for (Plant* again : {&plant, &other}) {
    again->restore(snapshot);
    EXPECT_EQ(again->snapshot(), snapshot);
    for (int i = 100; i < 200; ++i) {
      ASSERT_TRUE(again->step(shaken(vehicle, i)));
      ASSERT_EQ(seen(*again), first[static_cast<std::size_t>(i - 100)]) << i;
    }
  }
}

VehicleModel over_ground() {
  VehicleModel vehicle = read_vehicle("crazyflie");
  vehicle.environment.ground_z_m = 0.0;
  return vehicle;
}

TEST(Ground, CarriesTheVehicleAndIsLeftAgain) {
  const VehicleModel vehicle = over_ground();
  Plant plant = make_plant(vehicle, {});
  VehicleState state;
  state.position_W_m.z() = 0.3;
  plant.reset(state);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(plant.step({}));
  EXPECT_TRUE(plant.touches_ground());
  EXPECT_NEAR(plant.state().position_W_m.z(), 0.015, 1e-3);
  EXPECT_LT(plant.state().velocity_W_mps.norm(), 1e-3);
  RotorCommand up;
  for (std::size_t i = 0; i < 4; ++i) up.speed_radps[i] = 1.2 * vehicle.hover_speed_radps();
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(plant.step(up));
  EXPECT_FALSE(plant.touches_ground());
  EXPECT_GT(plant.state().position_W_m.z(), 1.0);
}

TEST(Ground, ChangesNoBitOfAFlightThatStaysAway) {
  const VehicleModel high = over_ground(), none = read_vehicle("crazyflie");
  Plant a = make_plant(high, high.effects), b = make_plant(none, none.effects);
  VehicleState state;
  state.position_W_m.z() = 50.0;
  a.reset(state);
  b.reset(state);
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(a.step(shaken(high, i)));
    ASSERT_TRUE(b.step(shaken(high, i)));
  }
  EXPECT_EQ(seen(a), seen(b));
}

// near the ground mj_step flies the body's twin; away from it the step is made of MuJoCo's own parts, or of sums in their order
TEST(Ground, StepInTheAirIsThatOfMuJoCoToTheBit) {
  for (const double product_kgm2 : {0.0, 2e-6}) {
    VehicleModel low = over_ground(), high = read_vehicle("crazyflie");
    for (VehicleModel* vehicle : {&low, &high})
      vehicle->inertia_B_kgm2(0, 1) = vehicle->inertia_B_kgm2(1, 0) = product_kgm2;
    Plant a = make_plant(low, low.effects), b = make_plant(high, high.effects);
    for (int i = 0; i < 2000; ++i) {
      VehicleState state = a.state();
      // near and far, at rest and fast: what is rounded depends on it
      const double far_m = std::pow(10.0, i % 7 - 3), speed_mps = i % 3 == 0 ? 0.0 : std::pow(10.0, i % 5 - 3);
      state.position_W_m = Vector3(far_m * std::sin(i), far_m * std::cos(3 * i), 0.06);
      state.velocity_W_mps = speed_mps * Vector3(std::cos(i), std::sin(2 * i), std::cos(5 * i));
      if (i % 50 == 0) {
        state.attitude_WB = Quaternion(Eigen::AngleAxisd(0.3, Vector3(std::sin(i), std::cos(i), 0.0)));
        state.body_rate_B_radps = Vector3(0.3, -0.4, 0.5);
      }
      for (Plant* plant : {&a, &b}) {
        plant->set_state(state);
        ASSERT_TRUE(plant->step(shaken(high, i)));
      }
      ASSERT_FALSE(a.touches_ground()) << i;
      ASSERT_EQ(seen(a), seen(b)) << i;
    }
  }
}

TEST(Ground, SnapshotOnTheGroundGivesTheSameBits) {
  const VehicleModel vehicle = over_ground();
  Plant plant = make_plant(vehicle, {});
  VehicleState state;
  state.position_W_m.z() = 0.05;
  state.velocity_W_mps = Vector3(0.3, 0.1, 0.0);
  plant.reset(state);
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(plant.step({}));
  ASSERT_TRUE(plant.touches_ground());
  const std::vector<double> snapshot = plant.snapshot();
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(plant.step({}));
  const std::vector<double> first = seen(plant);
  Plant other = make_plant(vehicle, {});
  for (Plant* again : {&plant, &other}) {
    again->restore(snapshot);
    for (int i = 0; i < 50; ++i) ASSERT_TRUE(again->step({}));
    EXPECT_EQ(seen(*again), first);
  }
}

TEST(Divergence, IsSaidAtItsStepAndForEver) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  TemporaryFolder folder;
  const auto home = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  for (const double poison : {nan, 1e300, std::numeric_limits<double>::infinity()}) {
    Plant plant = make_plant(vehicle, {});
    plant.reset({});
    ASSERT_TRUE(plant.step(shaken(vehicle, 0)));
    VehicleState state = plant.state();
    state.body_rate_B_radps.x() = poison;
    plant.set_state(state);
    EXPECT_FALSE(plant.step(shaken(vehicle, 1))) << poison;
    EXPECT_FALSE(plant.step(shaken(vehicle, 2))) << poison;
    // a reset is a new flight
    plant.reset({});
    EXPECT_TRUE(plant.step(shaken(vehicle, 0))) << poison;
    EXPECT_TRUE(plant.state().position_W_m.allFinite());
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  std::filesystem::current_path(home);
}

TEST(Divergence, OfACommandIsSaidToo) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  Plant plant = make_plant(vehicle, vehicle.effects);
  plant.reset({});
  RotorCommand command;
  command.speed_radps.fill(nan);
  bool finite = true;
  for (int i = 0; i < 3; ++i) finite = finite && plant.step(command);
  EXPECT_FALSE(finite);
}

TEST(MeasuredSpeed, DrivesTheBodyPastLagAndDelay) {
  const VehicleModel vehicle = read_vehicle("crazyflie");
  const std::vector<EffectSpec> late{{"motor_lag", {{"time_constant", "0.3"}}, "test", {}},
                                     {"actuation_delay", {{"delay", "0.1"}}, "test", {}}};
  Plant slow = make_plant(vehicle, late), quick = make_plant(vehicle, {});
  slow.set_speed_is_measured(true);
  for (Plant* plant : {&slow, &quick}) {
    plant->reset({});
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(plant->step(shaken(vehicle, i)));
  }
  EXPECT_EQ(slow.state().position_W_m, quick.state().position_W_m);
  EXPECT_EQ(slow.state().rotor_speed_radps, quick.state().rotor_speed_radps);
}

}  // namespace state_test
}  // namespace gustlab
