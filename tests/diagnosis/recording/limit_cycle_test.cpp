// Loops that run their rotors from one limit to the other.
#include "diagnosis/recording/limit_cycle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/diagnose.hpp"
#include "support/trials.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace limit_cycle_test {

// 10 s of commands that swing about hover, cut off at the limits
FlightData swinging(double amplitude_radps) {
  FlightData flight;
  flight.vehicle = test::crazyflie();
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  for (int k = 0; k < 1000; ++k) {
    RotorArray row{};
    for (std::size_t i = 0; i < 4; ++i)
      row[i] =
          std::clamp(flight.vehicle.hover_speed_radps() + amplitude_radps * std::sin(0.3 * k + static_cast<double>(i)),
                     0.0, flight.vehicle.max_speed_radps);
    time_s.push_back(0.01 * k);
    speed.push_back(row);
  }
  flight.commands = CommandRecord(time_s, speed, false);
  return flight;
}

TEST(ShareAtBothLimits, IsThatOfSignalsThatAreCutOff) {
  EXPECT_LT(share_at_both_limits({swinging(100.0)}), 0.01);
  EXPECT_GT(share_at_both_limits({swinging(1e4)}), 0.5);
  EXPECT_EQ(share_at_both_limits({}), 0.0);
  FlightData frozen = swinging(100.0);
  frozen.commands = CommandRecord({0.0, 1.0}, {RotorArray{}, RotorArray{}}, false);
  EXPECT_EQ(share_at_both_limits({frozen}), 0.0);
}

// a battery that is empty is at one limit
TEST(ShareAtBothLimits, IsSmallAtOneLimitAlone) {
  FlightData flight = swinging(100.0);
  std::vector<RotorArray> speed = flight.commands.speed_radps();
  for (RotorArray& row : speed)
    for (double& value : row) value = std::min(value, flight.vehicle.hover_speed_radps());
  flight.commands = CommandRecord(flight.commands.time_s(), speed, false);
  EXPECT_LT(share_at_both_limits({flight}), 0.01);
}

TEST(LimitCycleTrials, ShowLateRotorsAlone) {
  const TemporaryFolder folder;
  const Diagnosis found =
      diagnose(test::fly_trial(folder, {.vehicle = "iris",
                                        .controller = "indi",
                                        .fit = {"lemniscate"},
                                        .holdout = {"hover"},
                                        .sensors = {"pose", "gyroscope", "rotor_speed"},
                                        .step_s = 0.0025,
                                        .air_sd_N = 0.0,
                                        .concealed = R"({type = "actuation_delay", delay = 0.03})"}));
  ASSERT_EQ(found.effects.size(), 1u);
  EXPECT_EQ(found.effects.front().effect, "actuation_delay");
  EXPECT_TRUE(std::ranges::any_of(
      found.notes, [](const std::string& note) { return note.find("out of control") != std::string::npos; }));
}

}  // namespace limit_cycle_test
}  // namespace gustlab::diagnosis
