// The challenge on short flights: what the held-out flights have too stands, and what they have not goes.
#include "diagnosis/evidence/challenge.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/evidence/judge.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace {

constexpr auto center = R"({type = "center_of_mass", x = 6e-4, y = -4e-4})";

const Evidence* find(const std::vector<Evidence>& records) {
  const auto found = std::find_if(records.begin(), records.end(),
                                  [](const Evidence& record) { return record.effect == "center_of_mass"; });
  return found == records.end() ? nullptr : &*found;
}

Challenge challenged(const std::string& held_out, Selection& selection) {
  const Recordings flown = test::short_flights(center, {"multisine"}),
                   other = test::short_flights(held_out, {"multisine"});
  Session session = test::session_of(flown);
  selection = select_effects(session, {});
  return challenge(
      session, selection, {prepare(other.holdout, flown.vehicle, {}), {}, other.holdout}, [] { return std::nullopt; },
      1);
}

TEST(Challenge, WhatTheHeldOutFlightHasTooStands) {
  Selection selection;
  const Challenge result = challenged(center, selection);
  ASSERT_NE(find(result.records), nullptr);
  EXPECT_GT(find(result.records)->probability, named_from);
  EXPECT_GT(find(result.records)->held_out_gain, 0.0);
  EXPECT_EQ(find(result.withdrawn), nullptr);
  EXPECT_EQ(result.records.size(), selection.findings.size());
  EXPECT_EQ(result.regimes.size(), selection.findings.size());
}

TEST(Challenge, WhatItHasNotGoes) {
  Selection selection;
  const Challenge result = challenged("", selection);
  EXPECT_EQ(find(result.records), nullptr);
  ASSERT_NE(find(result.withdrawn), nullptr);
  EXPECT_LT(find(result.withdrawn)->probability, suspected_from);
  EXPECT_LT(find(result.withdrawn)->held_out_gain, 0.0);
}

}  // namespace
}  // namespace gustlab::diagnosis
