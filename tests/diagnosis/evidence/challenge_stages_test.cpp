// The challenge on short flights: what the held-out flights have too stands, and what they have not goes.
#include "diagnosis/evidence/challenge.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/evidence/judge.hpp"
#include "diagnosis/evidence/reference_fit.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace challenge_stages_test {

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
  selection = select_effects(session);
  return challenge(
      session, selection, {prepare(other.holdout, flown.vehicle, {}), {}, other.holdout}, [] { return std::nullopt; },
      1);
}

TEST(Challenge, WhatTheHeldOutFlightHasTooStands) {
  Selection selection;
  const Challenge result = challenged(center, selection);
  ASSERT_NE(find(result.records), nullptr);
  EXPECT_GT(find(result.records)->probability, named_from);
  EXPECT_GT(find(result.records)->held_out_delta_chi2, 0.0);
  EXPECT_EQ(find(result.withdrawn), nullptr);
  EXPECT_EQ(result.records.size(), selection.findings.size());
  EXPECT_EQ(result.regimes.size(), selection.findings.size());
  const auto answer = std::ranges::find(result.history, true, &JudgedSet::answer);
  ASSERT_EQ(std::ranges::count(result.history, true, &JudgedSet::answer), 1);
  EXPECT_EQ(answer->names.size(), result.records.size());
  EXPECT_EQ(answer->minus_two_log_likelihood, selection.how_unlikely);
  EXPECT_TRUE(answer->withdrawn.empty());
}

// it is in the flight that was fitted, in every part of it, and that is no name
TEST(Challenge, WhatItHasNotIsNotNamed) {
  Selection selection;
  const Challenge result = challenged("", selection);
  const Evidence* record = find(result.records) ? find(result.records) : find(result.withdrawn);
  ASSERT_NE(record, nullptr);
  EXPECT_LT(record->probability, named_from);
  EXPECT_LT(record->held_out_delta_chi2, 0.0);
  for (const Evidence& gone : result.withdrawn)
    EXPECT_TRUE(std::ranges::any_of(result.history, [&](const JudgedSet& set) {
      return std::ranges::count(set.withdrawn, gone.effect) > 0;
    })) << gone.effect;
}

// where torques swing, a single reference flight may itself have been fitted by another latency
TEST(ChallengeTrials, BesideOneReferenceFlightNoDelayIsNamed) {
  const Recordings late = test::short_flights(R"({type = "actuation_delay", delay = 0.015})", {"multisine"});
  for (const std::vector<std::string>& flights : {std::vector<std::string>{"multisine"}, {"multisine", "lemniscate"}}) {
    const Recordings good = test::short_flights("", flights);
    const ReferenceFit normal = ReferenceFlights(test::session_of(good).flights(), {}, good.fit, good.vehicle, 1).fit();
    Session session(prepare(late.fit, normal.vehicle, {}), normal.vehicle, 1);
    session.compare_with(normal.known);
    Selection selection = select_effects(session);
    const Challenge result = challenge(
        session, selection, {prepare(late.holdout, normal.vehicle, {}), {}, late.holdout}, [] { return std::nullopt; },
        1);
    std::vector<Evidence> all = result.records;
    all.insert(all.end(), result.withdrawn.begin(), result.withdrawn.end());
    const auto delay = std::ranges::find(all, "actuation_delay", &Evidence::effect);
    ASSERT_NE(delay, all.end());
    EXPECT_EQ(delay->lone_latency, flights.size() == 1);
    Evidence known = *delay;
    known.lone_latency = false;
    judge(known);
    if (flights.size() == 1) EXPECT_LT(delay->probability, std::min(named_from, 0.9 * known.probability));
    else EXPECT_EQ(delay->probability, known.probability);
  }
}

TEST(ExplainsMore, IsTheSetWithWhatWasConcealed) {
  Session session = test::session_of(test::short_flights(center, {"multisine"}));
  const Selection found = select_effects(session);
  const int group = session.catalogue().find("center_of_mass");
  ASSERT_NE(found.find(group), nullptr);
  const Selection rest = withdraw(session, found, {group});
  EXPECT_TRUE(explains_more(session, found, rest));
  EXPECT_FALSE(explains_more(session, rest, found));
  EXPECT_FALSE(explains_more(session, found, found));
}

// beside others that take from it what it gains
Evidence candidate(const std::string& effect, double probability, double delta_chi2) {
  Evidence record;
  record.effect = effect;
  record.probability = probability;
  record.delta_chi2 = record.delta_chi2_with_partner = delta_chi2;
  record.features = {{"undone", 0.1}, {"outweighed", 0.0}};
  return record;
}

TEST(Weakest, IsTheHopelessOneThatGainsLeast) {
  const std::vector<Evidence> records = {candidate("mass", 0.4, 5.0), candidate("inertia", 0.02, 40.0),
                                         candidate("battery_sag", 0.03, 30.0), candidate("motor_lag", 0.01, 60.0)};
  EXPECT_EQ(weakest(records, {0, 1, 2, 3}), 2u);
  EXPECT_EQ(weakest(records, {0, 1, 3}), 1u);
  EXPECT_EQ(weakest(records, {0}), 0u);
}

TEST(Weakest, IsTheLeastLikelyOneWhereNoneIsHopeless) {
  const std::vector<Evidence> records = {candidate("mass", 0.3, 50.0), candidate("inertia", 0.2, 40.0),
                                         candidate("battery_sag", 0.4, 30.0)};
  EXPECT_EQ(weakest(records, {0, 1, 2}), 1u);
}

// beside wrong partners a right name may look hopeless; one that ran into its bound describes nothing
TEST(Weakest, IsNotWhatGainsMostUnlessItRanIntoItsBound) {
  std::vector<Evidence> records = {candidate("thrust_scale", 0.003, 288.0), candidate("rotor_loss", 0.3, 83.0)};
  EXPECT_GT(probability_without_others(records[0]), 0.8);
  EXPECT_EQ(weakest(records, {0, 1}), 1u);
  // a wind where an attitude that is a little off would push just so: no other name makes it hopeless
  records[0].features = {{"tilt", 0.3}, {"undone", 1.0}, {"outweighed", 0.9}};
  EXPECT_EQ(weakest(records, {0, 1}), 0u);
  records[0].features = {{"undone", 0.1}, {"outweighed", 0.0}};
  records[0].at_bound = true;
  EXPECT_EQ(weakest(records, {0, 1}), 0u);
}

// of what is not likely, but without which held-out flights are predicted worse
TEST(NearestRival, KeepsHalfOfTheGainAndWasNotAskedBefore) {
  const Session session = test::session_of(test::short_flights("", {"multisine"}));
  const auto group = [&](const char* label) { return session.catalogue().find(std::string_view(label)); };
  Selection selection;
  Finding finding;
  finding.group = group("center_of_mass"), finding.delta_chi2 = 100.0;
  finding.rivals = {{group("constant_force"), 1.0, 5.0, false},
                    {group("mass"), 1.0, 10.0, true},
                    {group("rotor_loss#1"), 2.0, 20.0, false},
                    {group("rotor_loss#2"), 2.0, 49.0, false},
                    {group("inertia"), 3.0, 51.0, false}};
  Evidence needed = candidate("center_of_mass", 0.1, 100.0);
  needed.recovered_z = {1.0, 4.0, 4.0};
  const auto rival = [&](const Evidence& record, const std::set<int>& asked) {
    return nearest_rival(session.catalogue(), selection, finding, record, asked);
  };
  EXPECT_EQ(rival(needed, {}), group("rotor_loss#1"));
  EXPECT_EQ(rival(needed, {group("rotor_loss#1")}), group("rotor_loss#2"));
  EXPECT_EQ(rival(needed, {group("rotor_loss#1"), group("rotor_loss#2")}), std::nullopt);
  selection.at_bounds = {group("rotor_loss#1")};
  EXPECT_EQ(rival(needed, {}), group("rotor_loss#2"));
  Evidence other = needed;
  other.at_bound = true;
  EXPECT_EQ(rival(other, {}), std::nullopt);
  other = needed, other.recovered_z[1] = 1.0;
  EXPECT_EQ(rival(other, {}), std::nullopt);
  other = needed, other.recovered_z.clear();
  EXPECT_EQ(rival(other, {}), std::nullopt);
}

// a mass that the noise holds once a curve and a tilt that went with it have been withdrawn
TEST(ComesBack, WhatWasLikelyAndWasNotAskedBesideTheNamesThatStand) {
  const Session session = test::session_of(test::short_flights("", {"multisine"}));
  const auto group = [&](const char* label) { return session.catalogue().find(std::string_view(label)); };
  const int drag = group("rotor_drag"), mass = group("mass"), force = group("constant_force");
  Selection selection;
  selection.findings.emplace_back().group = drag;
  std::map<int, double> likeliest = {{drag, 0.99}, {mass, 0.93}, {force, 0.97}, {group("thrust_curve"), 0.79}};
  std::set<std::vector<int>> judged;
  const auto back = [&] { return comes_back(session, selection, likeliest, judged); };
  EXPECT_EQ(back(), mass);
  likeliest[mass] = 0.79;
  EXPECT_EQ(back(), std::nullopt);
  likeliest[mass] = 0.93;
  selection.at_bounds = {mass};
  EXPECT_EQ(back(), std::nullopt);
  selection.at_bounds.clear();
  judged.insert({std::min(drag, mass), std::max(drag, mass)});
  EXPECT_EQ(back(), std::nullopt);
}

}  // namespace challenge_stages_test
}  // namespace gustlab::diagnosis
