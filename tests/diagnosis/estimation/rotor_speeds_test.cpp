// Where rotor speeds are measured beside their commands, the way from one to the other is a measurement of its own (FORMATS.md §1).
#include <gmock/gmock.h>

#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace rotor_speeds_test {

Diagnosis with_rotor_speeds(const std::string& concealed) {
  const TemporaryFolder folder;
  test::TrialSettings trial;
  trial.fit = {"lemniscate", "multisine"};
  trial.holdout = {"circle"};
  trial.sensors.emplace_back("rotor_speed");
  trial.concealed = concealed;
  return diagnose(test::fly_trial(folder, trial));
}

using ::testing::Contains;
using ::testing::MatchesRegex;

TEST(RotorSpeedsTrials, NameNothingWhereNothingIsConcealed) {
  const Diagnosis d = with_rotor_speeds("");
  EXPECT_TRUE(d.effects.empty()) << to_json(d).dump(1);
  EXPECT_EQ(d.verdict, Verdict::consistent);
}

TEST(RotorSpeedsTrials, TellALagThatTheBodyCannot) {
  const Diagnosis d = with_rotor_speeds(R"({type = "motor_lag", time_constant = 0.06})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "motor_lag");
  EXPECT_NEAR(test::value_of(d.effects[0], "time_constant"), 0.06, 0.002);
  // held-out flights were not compared, and both figures were 0
  EXPECT_THAT(d.notes, Contains(MatchesRegex("commands predict the rotors' speeds to [0-9.]*[1-9][0-9.]* rad/s instead "
                                             "of [0-9.]*[1-9][0-9.]* .rms, held-out flights.*")));
}

TEST(RotorSpeedsTrials, TellADelay) {
  const Diagnosis d = with_rotor_speeds(R"({type = "actuation_delay", delay = 0.012})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "actuation_delay");
  EXPECT_NEAR(test::value_of(d.effects[0], "delay"), 0.012, 0.001);
}

// by time: these logs have no voltage
TEST(RotorSpeedsTrials, TellABatteryThatSags) {
  const Diagnosis d = with_rotor_speeds(R"({type = "battery_sag", rate = 0.004})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "battery_sag");
  EXPECT_NEAR(test::value_of(d.effects[0], "rate"), 0.004, 0.0004);
}

TEST(RotorSpeedsTrials, LeaveWhatTurnsTheBodyToTheBody) {
  const Diagnosis d = with_rotor_speeds(R"({type = "mass", delta = 0.06})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "mass");
}

}  // namespace rotor_speeds_test
}  // namespace gustlab::diagnosis
