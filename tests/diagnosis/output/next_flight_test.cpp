// What to fly next, and whether it then does what was promised.
#include <gmock/gmock.h>

#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::Lt;

// hovers and slow circles at one heading, and if wanted a flight of many sines with yaw; an attitude offset is concealed
Diagnosis diagnose_offset(const std::vector<std::string>& fit, bool large = false) {
  const TemporaryFolder folder;
  return diagnose(test::fly_trial(folder, {.vehicle = large ? "iris" : "crazyflie",
                                           .fit = fit,
                                           .holdout = {"spiral"},
                                           .duration_s = 12.0,
                                           .step_s = large ? 0.0025 : 0.002,
                                           .air_sd_N = large ? 0.1 : 0.003,
                                           .tables = R"(
[trajectory.circle]
period_s = 20.0
ramp_s = 2
start = "reference"
[trajectory.spiral]
ramp_s = 2
[trajectory.multisine]
center_m = [0, 0, 1.2]
yaw_amplitude_rad = 1.2
yaw_frequency_hz = 0.25
)",
                                           .concealed = R"({type = "attitude_offset", x = 0.02})"}));
}

TEST(NextFlightTrials, NamesAFlightThatThenSeparatesWhatCouldNotBeTold) {
  const Diagnosis before = diagnose_offset({"hover", "circle"});
  ASSERT_EQ(before.effects.size(), 1u) << to_json(before).dump(1);
  // at one heading a tilted sensor and a constant push look alike
  ASSERT_THAT(before.effects[0].classmates, Contains("attitude_offset"));
  ASSERT_THAT(before.effects[0].classmates, Contains("constant_force"));
  // the air of this room: 0.003 N on 28 g, 0.15 s
  EXPECT_NEAR(before.disturbance[0].after, 0.106, 0.025);
  EXPECT_THAT(before.disturbance[0].correlation_time_s, AllOf(Gt(0.08), Lt(0.3)));
  EXPECT_EQ(before.next_trajectory, "multisine") << before.next_why;
  EXPECT_THAT(before.next_why, HasSubstr("would separate"));
  EXPECT_EQ(to_json(before)["next_flight"]["parameters"]["yaw_amplitude_rad"], 1.2);

  const Diagnosis after = diagnose_offset({"hover", "circle", "multisine"});
  ASSERT_EQ(after.effects.size(), 1u);
  EXPECT_EQ(after.effects[0].classmates, std::vector<std::string>{"attitude_offset"});
}

TEST(NextFlightTrials, IsSizedByTheVehicle) {
  const Diagnosis d = diagnose_offset({"hover"}, true);
  EXPECT_FALSE(d.next_trajectory.empty());
  // five times the arm, five times the path
  const auto next = to_json(d)["next_flight"]["parameters"];
  EXPECT_GT(next.contains("amplitude_m") ? next["amplitude_m"][0].get<double>() : next["radius_m"].get<double>(), 1.5);
}

}  // namespace
}  // namespace gustlab::diagnosis
