// Sizes of effects when every other row of the logs is left out.
#include "diagnosis/evidence/half_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "diagnosis/selection/select_effects.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace half_rate_test {

Session with_every_other_row(Recordings flown) {
  for (FlightLog& log : flown.fit) log = every_other_row(std::move(log));
  return test::session_of(flown);
}

TEST(EveryOtherRow, KeepsTheFirstOfTwoOfItsKind) {
  FlightLog log;
  log.time_s = {0.0, 0.1, 0.2, 0.3, 0.4};
  log.columns = {{"px", {1.0, 2.0, 3.0, 4.0, 5.0}}};
  EXPECT_EQ(every_other_row(log).time_s, (std::vector<double>{0.0, 0.2, 0.4}));
  EXPECT_EQ(every_other_row(log).columns.front().values, (std::vector<double>{1.0, 3.0, 5.0}));
  // an input in every other row is in every other row of what is left
  const double none = std::nan("");
  log.columns.push_back({"u1", {none, 7.0, none, 8.0, none}});
  EXPECT_EQ(every_other_row(log).time_s, (std::vector<double>{0.0, 0.1, 0.4}));
}

// an effect is as large in half the rows, and twice as large where it is twice as large
void expect_of_the_size(const std::string& effect, const char* once, const char* doubled) {
  const auto flown = [](const char* concealed) {
    return test::short_flights(concealed, {"multisine", "lemniscate"}, 8.0);
  };
  const Recordings first = flown(once);
  Session session = test::session_of(first);
  const Selection selection = select_effects(session);
  const Finding* found = selection.find(session.catalogue().find(effect));
  ASSERT_NE(found, nullptr);
  const auto at = static_cast<std::size_t>(found - selection.findings.data());
  Session same = with_every_other_row(first), twice = with_every_other_row(flown(doubled));
  EXPECT_NEAR(changes_at_half_rate(same, session, selection).at(at), 0.0, 0.1);
  EXPECT_NEAR(changes_at_half_rate(twice, session, selection).at(at), 1.0, 0.1);
}

TEST(ChangesAtHalfRate, AreOfTheSize) {
  expect_of_the_size("mass", R"({type = "mass", delta = 0.05})", R"({type = "mass", delta = 0.1})");
}

// a load swings there as it does in all rows: without it a battery's sag stood in for it
TEST(HalfRateTrials, KnowALoadThatSwings) {
  expect_of_the_size("slung_load", R"({type = "slung_load", mass = 0.004, length = 0.3})",
                     R"({type = "slung_load", mass = 0.008, length = 0.3})");
}

// which of a log's sensors there are is as before; where it is not, nothing is compared
TEST(ChangesAtHalfRate, AreNotToldWithoutASensor) {
  const Recordings flown = test::short_flights(R"({type = "mass", delta = 0.05})", {"multisine"});
  Session session = test::session_of(flown);
  const Selection selection = select_effects(session);
  ASSERT_FALSE(selection.findings.empty());
  Recordings without = flown;
  for (FlightLog& log : without.fit) std::erase_if(log.columns, [](const LogColumn& c) { return c.name[0] == 'w'; });
  Session half = with_every_other_row(without);
  EXPECT_TRUE(changes_at_half_rate(half, session, selection).empty());
}

// With commands alone moments of inertia are not asked there.
TEST(HalfRateTrials, WhatCommandsAloneLeaveOutIsNoPhysics) {
  const TemporaryFolder folder;
  const Diagnosis found = diagnose(test::fly_trial(folder, {.vehicle = "crazyflie_21",
                                                            .controller = "mpc",
                                                            .fit = {"multisine"},
                                                            .holdout = {"hover"},
                                                            .sensors = {"pose", "gyroscope", "accelerometer"},
                                                            .duration_s = 15.0,
                                                            .log_rate_hz = 100.0,
                                                            .noise = 0.1,
                                                            .air_sd_N = 0.0,
                                                            .concealed = R"({type = "thrust_scale", delta = -0.08})"}));
  ASSERT_EQ(found.effects.size(), 1u);
  EXPECT_EQ(found.effects.front().effect, "thrust_scale");
}

// A simulated flight without noise, logged at a fifth of the loop's rate: moments of inertia stood in for what the rotors did between rows.
TEST(HalfRateTrials, WhatALogLeavesOutBetweenItsRowsIsNoPhysics) {
  const TemporaryFolder folder;
  const Diagnosis found =
      diagnose(test::fly_trial(folder, {.vehicle = "crazyflie_21",
                                        .controller = "l1",
                                        .fit = {"multisine"},
                                        .holdout = {"hover"},
                                        .sensors = {"pose", "velocity", "gyroscope", "accelerometer", "rotor_speed"},
                                        .duration_s = 15.0,
                                        .log_rate_hz = 100.0,
                                        .noise = 0.0,
                                        .air_sd_N = 0.0,
                                        .concealed = R"({type = "thrust_scale", delta = -0.08})"}));
  ASSERT_EQ(found.effects.size(), 1u);
  EXPECT_EQ(std::ranges::count(found.effects.front().classmates, "thrust_scale"), 1);  // or a mass, which pushes alike
  EXPECT_TRUE(std::ranges::any_of(found.rejected, [](const Rejected& r) {
    return r.effect == "inertia" && r.why.find("every other row") != std::string::npos;
  }));
}

}  // namespace half_rate_test
}  // namespace gustlab::diagnosis
