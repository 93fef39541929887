// What held-out flights lose without a finding, where a moment that nobody named turns the vehicle.
#include <gtest/gtest.h>

#include "diagnosis/evidence/gather_evidence.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace rollouts_without_each_test {

TEST(FlyWithoutEach, AForceIsJudgedAlongTheAttitudeAsItWasRecorded) {
  const Recordings flown = test::short_flights(R"({type = "mass", delta = -0.05}, {type = "center_of_mass", x = 3e-4})",
                                               {"multisine"}, 12.0);
  std::vector<Evidence> records(1);
  fly_without_each(recordings_to_fly(flown.holdout, flown.vehicle), flown.vehicle.effects,
                   {test::effect("mass", {{"delta", "-0.05"}})}, 1, records);
  ASSERT_EQ(records[0].recovered_z.size(), 3u);
  EXPECT_GT(records[0].recovered[1], 0.5);
  EXPECT_GT(records[0].recovered_z[1], 4.0);
}

// where no attitude is simulated, a mass that is wrong by as much again speaks against itself
TEST(FlyWithoutEach, AWrongForceLosesWhereTheAttitudeIsTakenAsItWasRecorded) {
  const Recordings flown = test::short_flights(R"({type = "mass", delta = -0.05})", {"multisine"}, 12.0);
  std::vector<Recording> held_out = recordings_to_fly(flown.holdout, flown.vehicle);
  for (Recording& recording : held_out) recording.collective_only = true;
  for (const char* delta : {"-0.05", "0.05"}) {
    std::vector<Evidence> records(1);
    fly_without_each(held_out, flown.vehicle.effects, {test::effect("mass", {{"delta", delta}})}, 1, records);
    ASSERT_EQ(records[0].recovered_z.size(), 3u);
    if (delta[0] == '-') EXPECT_GT(records[0].recovered_z[1], 4.0);
    else EXPECT_LT(records[0].recovered_z[1], -4.0);
  }
}

}  // namespace rollouts_without_each_test
}  // namespace gustlab::diagnosis
