// One set of effects against another: by what held-out flights say half a second ahead.
#include "diagnosis/evidence/set_against_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "diagnosis/evidence/gather_evidence.hpp"
#include "diagnosis/selection/alternatives.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace set_against_set_test {

TEST(LogRatio, IsNegativeForTheSetThatPredictsBetter) {
  const Recordings flown = test::short_flights(R"({type = "mass", delta = -0.05})", {"multisine"}, 12.0);
  const std::vector<Recording> held_out = recordings_to_fly(flown.holdout, flown.vehicle);
  const auto mass = [](const char* delta) { return std::vector<EffectSpec>{test::effect("mass", {{"delta", delta}})}; };
  const auto z = [&](const std::vector<EffectSpec>& some, const std::vector<EffectSpec>& others) {
    return log_ratio_z(held_out, flown.vehicle.effects, some, others, 1);
  };
  EXPECT_LT(z(mass("-0.05"), {}), -4.0);
  EXPECT_NEAR(z({}, mass("-0.05")), -z(mass("-0.05"), {}), 1e-9);
  EXPECT_EQ(z(mass("-0.05"), mass("-0.05")), 0.0);
  // with nine times the thrust, or ten, it is lost either way
  EXPECT_EQ(z({test::effect("thrust_scale", {{"delta", "8"}})}, {test::effect("thrust_scale", {{"delta", "9"}})}), 0.0);
  EXPECT_EQ(log_ratio_z({}, {}, mass("-0.05"), {}, 1), 0.0);
}

// a centre of mass that is off, and the set that has a rotor that lost thrust in its place
class OneForAnother : public ::testing::Test {
 protected:
  int group(const char* label) const { return session_.catalogue().find(std::string_view(label)); }
  Selection with_rotor() {
    Selection selection = select_effects(session_);
    const auto center =
        std::ranges::find(selection.findings, group("center_of_mass"), [](const Finding& f) { return f.group; });
    EXPECT_NE(center, selection.findings.end());
    for (const int c : session_.catalogue().group(center->group).columns)
      selection.value[c] = session_.catalogue().column(c).nominal;
    *center = Finding{};
    center->group = group("rotor_loss#1");
    selection.value[session_.catalogue().group(center->group).columns.front()] = 0.02;
    std::ranges::sort(selection.findings, {}, &Finding::group);
    return selection;
  }

  Recordings flown_ = test::short_flights(R"({type = "center_of_mass", x = 6e-4, y = -4e-4})", {"multisine"});
  Session session_ = test::session_of(flown_);
};

TEST_F(OneForAnother, TheSetThatFliesBetterIsFound) {
  const Selection wrong = with_rotor();
  const std::vector<Recording> held_out = recordings_to_fly(flown_.holdout, flown_.vehicle);
  std::set<std::vector<int>> tried;
  const std::optional<Selection> better = flies_better(session_, wrong, held_out, {}, tried);
  ASSERT_TRUE(better.has_value());
  EXPECT_NE(better->find(group("center_of_mass")), nullptr);
  EXPECT_EQ(better->find(group("rotor_loss#1")), nullptr);
  EXPECT_TRUE(tried.contains(wrong.groups()));
  // each set is asked once, and the session is as it was where none flies better
  const Eigen::VectorXd value = session_.value();
  EXPECT_FALSE(flies_better(session_, *better, held_out, {}, tried).has_value());
  EXPECT_EQ(session_.value(), value);
}

TEST_F(OneForAnother, WhatIsLeftOutAndWhatEveryFlightHasForItselfIsNoAlternative) {
  const Selection wrong = with_rotor();
  const auto offers = [&](const std::set<int>& left_out, int g) {
    return std::ranges::any_of(alternatives(session_, wrong, left_out),
                               [&](const std::vector<int>& set) { return std::ranges::count(set, g) > 0; });
  };
  EXPECT_TRUE(offers({}, group("center_of_mass")));
  EXPECT_FALSE(offers({group("center_of_mass")}, group("center_of_mass")));
  EXPECT_FALSE(offers({}, group("constant_force")));
  EXPECT_FALSE(offers({}, group("steady_wind")));
}

}  // namespace set_against_set_test
}  // namespace gustlab::diagnosis
