// What to fly next, and whether it then does what was promised.
#include "diagnosis/output/next_flight.hpp"

#include <gmock/gmock.h>

#include "support/flight_data.hpp"
#include "support/trials.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace next_flight_test {

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

// a hover after which these effects were not told
Diagnosis next_after_hover(const std::vector<NotIdentifiable>& unseen) {
  const VehicleModel vehicle = test::crazyflie();
  const Session session({test::flight_of(
                            vehicle, 4.0, 0.02, [](double) { return Motion{}; },
                            [&](double) { return test::all_at(vehicle.hover_speed_radps()); })},
                        vehicle, 1);
  Selection selection;
  selection.value = session.value();
  selection.noise_selected = session.noise;
  Diagnosis d;
  d.not_identifiable = unseen;
  suggest_flight(session, selection, 1, d);
  return d;
}

TEST(NextFlight, WouldShowADragThatHoverHides) {
  const Diagnosis d = next_after_hover({{"quadratic_drag", "too slow"}});
  // the fastest of the library: 1.8 m/s on a radius of 0.8 m, for an arm of 4.4 cm
  EXPECT_EQ(d.next_trajectory, "circle") << d.next_why;
  EXPECT_EQ(d.next_why, "would show quadratic_drag (flown fast)");
}

TEST(NextFlight, IsNotSuggestedWhereNothingIsOpenOrNoFlightWouldTellIt) {
  EXPECT_EQ(next_after_hover({}).next_trajectory, "");
  // the log knows of no ground
  EXPECT_EQ(next_after_hover({{"ground_effect", "no ground height"}}).next_trajectory, "");
}

}  // namespace next_flight_test
}  // namespace gustlab::diagnosis
