// Commands of one flight that are stamped earlier than those of another, by an amount that is known.
#include "diagnosis/alignment/command_offsets.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace command_offsets_test {

constexpr double early_s = 0.04;

class CommandOffsets : public ::testing::Test {
 protected:
  std::vector<double> offsets() {
    findings.clear();
    return command_offsets({flights[0]}, {flights[1]}, flown.vehicle, findings);
  }
  const Recordings flown = test::short_flights("", {"multisine", "lemniscate"}, 6.0, 100.0);
  std::vector<FlightData> flights = prepare(flown.fit, flown.vehicle, {});
  std::vector<LogFinding> findings;
};

TEST_F(CommandOffsets, ReadCommandsAsMuchLaterAsTheyAreEarly) {
  EXPECT_EQ(offsets(), (std::vector<double>{0.0, 0.0}));
  EXPECT_TRUE(findings.empty());
  flights[1].commands.delay(-early_s);
  const std::vector<double> found = offsets();
  EXPECT_EQ(found[0], 0.0);
  EXPECT_NEAR(found[1], early_s, 0.01);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].file, flights[1].label);
}

// all late alike: a delay of the vehicle; parts of one recording: one clock
TEST_F(CommandOffsets, WhatAllShareIsPhysicsAndARecordingHasOneClock) {
  for (FlightData& flight : flights) flight.commands.delay(-early_s);
  EXPECT_EQ(offsets(), (std::vector<double>{0.0, 0.0}));
  flights[0].commands.delay(early_s);
  flights[1].file = flights[0].file;
  EXPECT_EQ(offsets(), (std::vector<double>{0.0, 0.0}));
}

// a parabola with its top at `at_s`, and as a racer in rough air had it: no more at 24 ms than at 12 or 36
TEST(Likeliest, IsAPeakAndNoSlope) {
  const auto parabola = [](double at_s) {
    return [at_s](double x) { return 400.0 * (1.0 - std::pow((x - at_s) / at_s, 2)); };
  };
  EXPECT_TRUE(is_likeliest(0.024, parabola(0.024)));
  EXPECT_TRUE(is_likeliest(0.024, parabola(0.026)));
  EXPECT_FALSE(is_likeliest(0.024, parabola(0.012)));
  EXPECT_FALSE(is_likeliest(0.024, parabola(0.048)));
  EXPECT_FALSE(is_likeliest(0.024, [](double x) { return x < 0.02 ? 180.0 : 134.6; }));
  EXPECT_FALSE(is_likeliest(0.024, [&](double x) { return 0.2 * parabola(0.024)(x); }));  // too little
}

}  // namespace command_offsets_test
}  // namespace gustlab::diagnosis
