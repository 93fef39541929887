// Rotors and body of one rollout against closed forms: a first-order lag, and a rise at constant acceleration.
#include "diagnosis/rollout/rollout.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace rollout_test {

constexpr double lag_s = 0.05, step_at_s = 0.5, more = 1.1;

VehicleModel vehicle() {
  VehicleModel model = test::crazyflie();
  model.effects.clear();
  return model;
}

// level at one place for two seconds at 100 Hz, while all commands rise by a tenth
FlightLog rising() {
  FlightLog log;
  log.path = "rising.csv";
  log.meta.hold = Hold::zoh;
  for (const char* name : {"px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz", "wx", "wy", "wz"})
    log.columns.push_back({name, std::vector<double>(200, name == std::string("qw") ? 1.0 : 0.0)});
  for (const char* name : {"u1", "u2", "u3", "u4"}) log.columns.push_back({name, {}});
  for (int k = 0; k < 200; ++k) {
    log.time_s.push_back(0.01 * k);
    for (std::size_t c = 13; c < 17; ++c)
      log.columns[c].values.push_back(vehicle().hover_speed_radps() * (0.01 * k < step_at_s - 1e-9 ? 1.0 : more));
  }
  return log;
}

TEST(Rollout, RotorsFollowTheirCommandsAsTheLagHasIt) {
  const Recording recording(rising(), vehicle(), {});
  Rollout rollout(recording, {test::effect("motor_lag", {{"time_constant", "0.05"}})});
  const std::vector<RotorArray> speeds = rollout.rotor_speeds();
  ASSERT_EQ(speeds.size(), 200u);
  for (std::size_t k = 0; k < 200; ++k) {
    const double since_s = 0.01 * static_cast<double>(k) - step_at_s;
    const double wanted = since_s <= 0.0 ? 1.0 : more + (1.0 - more) * std::exp(-since_s / lag_s);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(speeds[k][i] / vehicle().hover_speed_radps(), wanted, 1e-9) << k;
  }
}

TEST(Rollout, WithATenthMoreSpeedTheVehicleRisesAtAFifthOfGravity) {
  const Recording recording(rising(), vehicle(), {});
  Rollout rollout(recording, {});
  const std::vector<RotorArray> speeds = rollout.rotor_speeds();
  const std::size_t row = 100;
  const VehicleState start = rollout.start(row);
  EXPECT_NEAR(start.time_s, 1.0, 1e-12);
  rollout.begin(start, speeds);
  const double acceleration_mps2 = (more * more - 1.0) * vehicle().gravity_mps2;
  // between two steps of the plant as well
  for (const double after_s : {0.1, 0.2503, 0.8}) {
    Measured seen;
    ASSERT_TRUE(rollout.run_to(start.time_s + after_s, seen));
    EXPECT_NEAR(seen.velocity_W_mps.z(), acceleration_mps2 * after_s, 1e-9) << after_s;
    // Euler's step moves a body by half an acceleration times the step squared too much
    EXPECT_NEAR(seen.position_W_m.z(), 0.5 * acceleration_mps2 * after_s * (after_s + recording.step_s), 1e-6)
        << after_s;
    EXPECT_LT(seen.position_W_m.head<2>().norm() + seen.body_rate_B_radps.norm(), 1e-9);
  }
}

TEST(Rollout, ALatePoseIsOfATimeBefore) {
  const Recording recording(rising(), vehicle(), {});
  const Rollout rollout(recording, {test::effect("pose_delay", {{"delay", "0.015"}})});
  EXPECT_EQ(rollout.pose_delay_s(), 0.015);
  EXPECT_NEAR(rollout.start(100).time_s, 1.0 - 0.015, 1e-12);
}

// the recorded attitude is 0.1 rad off: the body leans the other way, and stays so
TEST(Rollout, AlongTheRecordedAttitudeAFrameThatIsTurnedStaysTurned) {
  Recording recording(rising(), vehicle(), {});
  recording.collective_only = true;
  Rollout rollout(recording, {test::effect("attitude_offset", {{"x", "0.1"}})});
  const std::vector<RotorArray> speeds = rollout.rotor_speeds();
  const VehicleState start = rollout.start(100);
  rollout.begin(start, speeds);
  Measured seen;
  ASSERT_TRUE(rollout.run_to(start.time_s + 0.5, seen));
  EXPECT_NEAR(seen.attitude_WB.angularDistance(Quaternion::Identity()), 0.0, 1e-9);
  EXPECT_NEAR(std::abs(seen.velocity_W_mps.y()), 0.5 * more * more * vehicle().gravity_mps2 * std::sin(0.1), 1e-3);
}

}  // namespace rollout_test
}  // namespace gustlab::diagnosis
