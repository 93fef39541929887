// Commands of one flight that are stamped earlier than those of another, by an amount that is known.
#include "diagnosis/alignment/command_offsets.hpp"

#include <gtest/gtest.h>

#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace {

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

}  // namespace
}  // namespace gustlab::diagnosis
