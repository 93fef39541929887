// The low-level loops, each over the vehicles that it is for.
#include "control/low_level.hpp"

#include <gmock/gmock.h>

#include "control/attitude.hpp"
#include "control/rotors.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/random.hpp"
#include "support/fly.hpp"
#include "support/vehicles.hpp"

namespace gustlab {
namespace low_level_test {

struct Case {
  VehicleModel vehicle;
  LowLevel loop;
};

std::vector<Case> cases() {
  std::vector<Case> all{{test::crazyflie(), LowLevel::crazyflie},
                        {test::iris(), LowLevel::ardupilot},
                        {test::crazyflie(), LowLevel::generic},
                        {test::iris(), LowLevel::generic}};
  for (int count = 3; count <= 8; ++count) all.push_back({test::ring(count, 1.5, 0.25, 0.03), LowLevel::generic});
  return all;
}

TEST(LowLevelOf, GoesByTheVehiclesName) {
  EXPECT_EQ(low_level_of("auto", test::crazyflie()), LowLevel::crazyflie);
  EXPECT_EQ(low_level_of("auto", test::iris()), LowLevel::ardupilot);
  EXPECT_EQ(low_level_of("auto", test::ring(6, 1.0, 0.2, 0.0)), LowLevel::generic);
  EXPECT_EQ(low_level_of("generic", test::iris()), LowLevel::generic);
  EXPECT_THROW(low_level_of("px4", test::iris()), ConfigError);
}

TEST(TicksPerUpdate, MustBeWhole) {
  EXPECT_EQ(ticks_per_update("test", 100.0, 0.002), 5);
  EXPECT_EQ(ticks_per_update("test", 400.0, 0.0025), 1);
  EXPECT_THROW(ticks_per_update("test", 40.0, 0.002), ConfigError);
  EXPECT_THROW(ticks_per_update("test", 1000.0, 0.002), ConfigError);
}

// GIVEN hover WHEN hover is asked for THEN the rotors turn at hover speed
TEST(LowLevelLoop, AtHoverAsksForHover) {
  for (const Case& c : cases()) {
    const double period_s = 1.0 / base_rate_hz(c.loop);
    const auto loop = make_low_level(c.loop, c.vehicle, period_s);
    Observation observation;
    observation.rotor_speed_radps.fill(c.vehicle.hover_speed_radps());
    loop->reset(observation);
    loop->command({c.vehicle.weight_N()});
    const Mixer mixer(c.vehicle);
    // unequal rotors of the lead's model need a moment
    RotorCommand command;
    for (int i = 0; i < 500; ++i) command = loop->update(observation);
    EXPECT_LT(mixer.torque_B_Nm(command.speed_radps).norm(), 1e-9 * c.vehicle.weight_N()) << c.vehicle.name;
    EXPECT_NEAR(mixer.force_B_N(command.speed_radps).z(), c.vehicle.weight_N(), 1e-6 * c.vehicle.weight_N());
  }
}

// flies attitude only, from rest at an attitude with a little spin; the last tilt and heading error
double settled_error_rad(const Case& c, const Quaternion& start, const Quaternion& target, double duration_s) {
  const double period_s = 1.0 / base_rate_hz(c.loop);
  Plant plant(c.vehicle, test::vehicle_effects(c.vehicle), {.step_s = period_s / 2.0});
  VehicleState state;
  state.position_W_m.z() = 1000.0;
  state.attitude_WB = start;
  state.rotor_speed_radps.fill(c.vehicle.hover_speed_radps());
  plant.reset(state);
  const auto loop = make_low_level(c.loop, c.vehicle, period_s);
  loop->reset(plant.observe(false));
  for (int tick = 0; tick < static_cast<int>(duration_s / period_s); ++tick) {
    // a position loop asks anew all the time
    if (tick % 5 == 0) loop->command({c.vehicle.weight_N(), target});
    const RotorCommand command = loop->update(plant.observe(false));
    for (int k = 0; k < 2; ++k)
      if (!plant.step(command)) return 1e9;
  }
  const Quaternion last = plant.state().attitude_WB;
  // three rotors leave the heading free
  if (c.vehicle.rotor_count == 3) return (last * Vector3::UnitZ()).cross(target * Vector3::UnitZ()).norm();
  return last.angularDistance(target);
}

// the Iris has little yaw torque (0.00198 m): with ArduPilot's gains its heading rings for half a minute
double settles_s(const Case& c) { return c.loop == LowLevel::ardupilot ? 40.0 : 12.0; }

// GIVEN any attitude within 60 degrees of tilt WHEN level is asked for THEN the body gets there
TEST(LowLevelLoop, ConvergesFromEveryReasonableAttitude) {
  for (const Case& c : cases())
    for (std::uint64_t i = 0; i < 12; ++i) {
      const auto u = RandomStream(1, 0, "low_level_test").uniform4(i);
      const Vector3 axis(std::cos(2.0 * pi * u[0]), std::sin(2.0 * pi * u[0]), 0.0);
      const Quaternion start =
          from_euler({0.0, 0.0, 2.0 * pi * u[1]}) * Quaternion(Eigen::AngleAxisd(u[2] * pi / 3.0, axis));
      const Quaternion target = from_euler({0.2, -0.15, 0.5});
      EXPECT_LT(settled_error_rad(c, start, target, settles_s(c)), 0.02) << c.vehicle.name << " start " << i;
    }
}

// GIVEN a vehicle upside down WHEN level is asked for THEN loops on quaternions right it
TEST(LowLevelLoop, RightsItselfFromUpsideDown) {
  for (const Case& c : cases())
    EXPECT_LT(settled_error_rad(c, Quaternion(Eigen::AngleAxisd(pi - 0.05, Vector3::UnitX())), Quaternion::Identity(),
                                settles_s(c)),
              0.02)
        << c.vehicle.name;
}

TEST(LowLevelLoop, LetsANanThrough) {
  for (const Case& c : cases()) {
    const auto loop = make_low_level(c.loop, c.vehicle, 1.0 / base_rate_hz(c.loop));
    loop->reset({});
    loop->command({c.vehicle.weight_N()});
    Observation observation;
    observation.body_rate_B_radps.y() = std::nan("");
    EXPECT_TRUE(std::isnan(loop->update(observation).speed_radps[0])) << c.vehicle.name;
    loop->reset({});
    loop->command({std::nan("")});
    EXPECT_TRUE(std::isnan(loop->update({}).speed_radps[0])) << c.vehicle.name;
  }
}

}  // namespace low_level_test
}  // namespace gustlab
