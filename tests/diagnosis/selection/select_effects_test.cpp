// The search on a short flight with two concealed effects: what it finds, what goes and comes back, and what it makes of a reference flight.
#include "diagnosis/selection/select_effects.hpp"

#include <gmock/gmock.h>

#include "diagnosis/evidence/reference_fit.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace select_effects_test {

using ::testing::IsSupersetOf;

class SelectEffects : public ::testing::Test {
 protected:
  struct Found {
    Recordings recordings = test::short_flights(
        R"({type = "mass", delta = 0.1}, {type = "center_of_mass", x = 6e-4, y = -4e-4})", {"multisine"});
    Session session = test::session_of(recordings);
    Selection selection = select_effects(session);
  };
  static const Found& found() {
    static const Found once;
    return once;
  }
  // the session is moved by whoever selects with it
  const Recordings& recordings = found().recordings;
  Session session = found().session;
  const Selection& selection = found().selection;

  std::vector<std::string> names(const Selection& some) const {
    std::vector<std::string> result;
    for (const int g : some.groups()) result.emplace_back(session.catalogue().group(g).row->name);
    return result;
  }
  int column(const char* effect, std::size_t parameter = 0) const {
    return session.catalogue().group(session.catalogue().find(effect)).columns[parameter];
  }
};

TEST_F(SelectEffects, FindsWhatWasConcealedWithItsSize) {
  ASSERT_THAT(names(selection), IsSupersetOf({"mass", "center_of_mass"}));
  EXPECT_NEAR(selection.value[column("mass")], 0.1, 0.01);
  EXPECT_NEAR(selection.value[column("center_of_mass")], 6e-4, 6e-5);
  EXPECT_NEAR(selection.value[column("center_of_mass", 1)], -4e-4, 6e-5);
}

// every number of a finding is a difference of two least-squares fits on the Gram matrices that the selection hands out
TEST_F(SelectEffects, GainsAreLossesWithoutOrWithOne) {
  const Eigen::MatrixXd total = selection.grams.total();
  const auto loss = [&](std::vector<int> groups, int without = -1, int nor = -1) {
    std::erase_if(groups, [&](int g) { return g == without || g == nor; });
    return solve(total, session.with_biases(groups)).loss;
  };
  const std::vector<int> all = selection.groups();
  EXPECT_NEAR(selection.loss_selected, loss(all), 1e-9 * selection.loss_selected);
  EXPECT_NEAR(selection.loss_nominal, loss({}), 1e-9 * selection.loss_nominal);
  for (const Finding& finding : selection.findings) {
    double with_partner = finding.delta_chi2;
    for (const int partner : all)
      if (partner != finding.group)
        with_partner = std::min(with_partner, loss(all, finding.group, partner) - selection.loss_selected);
    EXPECT_NEAR(finding.delta_chi2, loss(all, finding.group) - loss(all), 1e-6 * finding.delta_chi2);
    EXPECT_NEAR(finding.delta_chi2_with_partner, with_partner, 1e-6 * finding.delta_chi2);
  }
}

// the weaker of the two is asked beside the stronger one, which needs no help; the stronger one beside nothing
TEST_F(SelectEffects, WhatANameGainsAloneIsBesideFarStrongerOnes) {
  const Eigen::MatrixXd total = selection.grams.total();
  const auto loss = [&](const std::vector<int>& groups) { return solve(total, session.with_biases(groups)).loss; };
  ASSERT_EQ(selection.findings.size(), 2u);
  const Finding *weak = &selection.findings[0], *strong = &selection.findings[1];
  if (weak->delta_chi2 > strong->delta_chi2) std::swap(weak, strong);
  const double without_weak = loss({}) - loss({strong->group});
  ASSERT_GT(without_weak, decisions::far_more * weak->delta_chi2);
  EXPECT_NEAR(weak->delta_chi2_alone, weak->delta_chi2, 1e-6 * selection.loss_nominal);
  EXPECT_NEAR(strong->delta_chi2_alone, without_weak, 1e-6 * selection.loss_nominal);
}

TEST_F(SelectEffects, WhatIsWithdrawnComesBackWhenItStillPays) {
  std::set<std::vector<int>> tried;
  if (const std::optional<Selection> more = look_again(session, selection, tried)) {
    EXPECT_THAT(more->groups(), IsSupersetOf(selection.groups()));
  }
  const int mass = session.catalogue().find("mass");
  const Selection rest = withdraw(session, selection, {mass});
  EXPECT_EQ(rest.find(mass), nullptr);
  EXPECT_NE(rest.find(session.catalogue().find("center_of_mass")), nullptr);
  EXPECT_EQ(rest.value[column("mass")], session.catalogue().nominal()[column("mass")]);
  const std::optional<Selection> again = look_again(session, rest, tried);
  ASSERT_TRUE(again);
  ASSERT_FALSE(tried.empty());
  EXPECT_THAT(again->groups(), IsSupersetOf(rest.groups()));
  EXPECT_NE(again->find(mass), nullptr);
  EXPECT_NEAR(again->value[column("mass")], selection.value[column("mass")], 5e-3);
}

TEST_F(SelectEffects, WhatIsLeftOutIsNotAskedAgain) {
  const int mass = session.catalogue().find("mass");
  const Selection rest = withdraw(session, selection, {mass}, {mass});
  std::set<std::vector<int>> tried;
  if (const std::optional<Selection> again = look_again(session, rest, tried, {mass})) {
    EXPECT_EQ(again->find(mass), nullptr);
  }
}

TEST_F(SelectEffects, WithinBoundsNothingIsLeftOut) {
  Session fresh = test::session_of(recordings);
  const Selection within = select_within_bounds(fresh);
  EXPECT_TRUE(within.at_bounds.empty());
  EXPECT_EQ(within.groups(), selection.groups());
  EXPECT_EQ(within.value, selection.value);
}

// a moment of inertia that is larger than any file is wrong by: whatever it stands for is looked for without it
TEST(WithinBoundsTrials, AGroupAtItsBoundIsNotAsked) {
  const Recordings flown = test::short_flights(
      R"({type = "inertia", delta_x = 1.1, delta_y = 1.1, delta_z = 1.1}, {type = "center_of_mass", x = 6e-4, y = -4e-4})",
      {"multisine"});
  Session session = test::session_of(flown);
  const int inertia = session.catalogue().find("inertia");
  Session other = session;
  const Selection bent = select_effects(other);
  ASSERT_NE(bent.find(inertia), nullptr);
  ASSERT_TRUE(at_its_bound(session.catalogue(), bent.value, inertia));
  const Selection within = select_within_bounds(session);
  EXPECT_THAT(within.at_bounds, ::testing::Contains(inertia));
  EXPECT_EQ(within.find(inertia), nullptr);
  const Selection rest = withdraw(session, within, within.groups());
  EXPECT_EQ(rest.at_bounds, within.at_bounds);
  std::set<std::vector<int>> tried;
  if (const std::optional<Selection> again = look_again(session, rest, tried)) {
    EXPECT_EQ(again->find(inertia), nullptr);
  }
  // asked for all the same, it runs to its bound once more, and the search ends
  EXPECT_THAT(with_also(other, bent, {inertia}, bent.value).at_bounds, ::testing::Contains(inertia));
}

// −2 log likelihood with a selection, under the noise that was learned beside it; the session is the one that made it
double how_unlikely(const Session& session, const Selection& selection) {
  const std::vector<int> columns = session.with_biases(selection.groups());
  Fit fit = solve(selection.grams.total(), columns);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = session.catalogue().column(columns[i]);
    fit.coefficient[static_cast<Eigen::Index>(i)] -= (session.value()[columns[i]] - column.nominal) / column.natural;
  }
  return session.minus_two_log_likelihood(columns, fit);
}

// beside a lag of 60 ms: the search begun anew ends in a set that is less likely than what is left of the one before
TEST(WithinBoundsTrials, KeepsWhatIsLeftWhereTheFlightsAreLikelierWithIt) {
  const Recordings flown = test::short_flights(
      R"({type = "inertia", delta_x = 1.3, delta_y = 1.3, delta_z = 1.3}, {type = "motor_lag", time_constant = 0.06})",
      {"multisine"});
  Session session = test::session_of(flown), without = session;
  const Selection within = select_within_bounds(session);
  ASSERT_FALSE(within.at_bounds.empty());
  for (const int group : within.at_bounds)
    for (const std::vector<int> all = without.catalogue().group(group).columns; const int c : all) without.freeze(c);
  const Selection anew = select_effects(without);
  // 414
  EXPECT_LT(within.how_unlikely, anew.how_unlikely - 200.0);

  // the session is as that set left it; transitions are kept while they hardly change
  const double price = within.grams.price(session.with_biases(within.groups()).size());
  EXPECT_NEAR(how_unlikely(session, within) + price, within.how_unlikely,
              0.1 * (anew.how_unlikely - within.how_unlikely));
}

// flights that keep their heading tell no moment of inertia in yaw; fitted, it took the moments in roll and pitch with it out of their bounds
TEST(UnidentifiableNumbersTrials, AreNotAsked) {
  const auto asked_of = [](const char* trajectory) {
    const Recordings flown =
        test::short_flights(R"({type = "inertia", delta_x = 0.3, delta_y = 0.3, delta_z = 0.3})", {trajectory}, 8.0);
    Session session = test::session_of(flown);
    const Selection found = select_effects(session);
    const int inertia = session.catalogue().find("inertia");
    EXPECT_NE(found.find(inertia), nullptr) << trajectory;
    EXPECT_EQ(session.catalogue().asks_last(inertia), session.catalogue().group(inertia).columns.size() == 3);
    return session.catalogue().group(inertia).columns.size();
  };
  EXPECT_EQ(asked_of("multisine"), 3u);
  EXPECT_EQ(asked_of("lemniscate"), 2u);
}

// what imitates an effect that is not asked is as good with that effect in its place, which says less
class LeftOut : public ::testing::TestWithParam<const char*> {};
TEST_P(LeftOut, DoesNotComeBackInPlaceOfWhatImitatesIt) {
  const Recordings flown = test::short_flights(GetParam(), {"multisine"});
  Session session = test::session_of(flown);
  const Selection found = select_effects(session);
  ASSERT_FALSE(found.findings.empty());
  for (const int group : found.groups()) {
    Session again = session;
    std::set<std::vector<int>> tried;
    const Selection rest = withdraw(again, found, {group}, {group});
    EXPECT_EQ(rest.find(group), nullptr) << session.catalogue().group(group).label;
    if (const std::optional<Selection> more = look_again(again, rest, tried, {group})) {
      EXPECT_EQ(more->find(group), nullptr) << session.catalogue().group(group).label;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(
    Effects, LeftOut,
    ::testing::Values(
        R"({type = "thrust_curve", curvature = 0.25}, {type = "mass", delta = 0.1})",
        R"({type = "inertia", delta_x = 0.3, delta_y = 0.3, delta_z = 0.3}, {type = "mass", delta = 0.1})",
        R"({type = "thrust_scale", delta = -0.1}, {type = "quadratic_drag", area_xy = 0.01, area_z = 0.01})"));

// what nobody names any more is no noise of the predictions: it would gain as much as before
TEST(SelectEffectsOfFilteredLogs, WhatWasWithdrawnIsNoNoise) {
  const Recordings flown = test::short_flights(R"({type = "mass", delta = 0.1})", {"multisine"}, 12.0, 100.0);
  const std::vector<FlightData> flights = prepare(flown.fit, flown.vehicle, {});
  Session session(flights, flown.vehicle, 1, flights);
  ASSERT_TRUE(session.shoots());
  const Selection found = select_effects(session);
  ASSERT_FALSE(found.findings.empty());
  const double gained = found.loss_nominal - found.loss_selected;
  const Selection rest = withdraw(session, found, found.groups());
  ASSERT_TRUE(rest.findings.empty());
  EXPECT_GT(std::ranges::max(rest.alone, {}, &std::pair<int, double>::second).second, 0.1 * gained);
}

// whitened by noise that was learned without an effect, flights lose hardly more without it: only the noise itself says how unlikely they are
TEST_F(SelectEffects, FlightsAreLikelierWithWhatTheyHaveWhateverNoiseWasLearned) {
  const double with = how_unlikely(session, selection);
  const Selection rest = withdraw(session, selection, selection.groups());
  ASSERT_TRUE(rest.findings.empty());
  EXPECT_LT(with, how_unlikely(session, rest) - 100.0);
}

TEST(SelectEffectsOfFilteredLogs, FlightsAreLikelierWithWhatTheyHaveWhateverNoiseWasLearned) {
  const Recordings flown = test::short_flights(R"({type = "mass", delta = 0.1})", {"multisine"}, 12.0, 100.0);
  const std::vector<FlightData> flights = prepare(flown.fit, flown.vehicle, {});
  Session session(flights, flown.vehicle, 1, flights);
  const Selection found = select_effects(session);
  const double with = how_unlikely(session, found);
  const Selection rest = withdraw(session, found, found.groups());
  ASSERT_TRUE(rest.findings.empty());
  EXPECT_LT(with, how_unlikely(session, rest) - 100.0);
}

TEST_F(SelectEffects, WhatWasTriedIsNotTriedAgainAndTheNoiseIsPutBack) {
  const Selection rest = withdraw(session, selection, {session.catalogue().find("mass")});
  std::set<std::vector<int>> tried;
  for (int g = 0; g < std::ssize(session.catalogue().groups()); ++g) {
    std::vector<int> more = rest.groups();
    more.push_back(g);
    std::ranges::sort(more);
    tried.insert(more);
  }
  const NoiseModel noise = session.noise;
  const double misfit = session.misfit({}, {});
  EXPECT_FALSE(look_again(session, rest, tried));
  EXPECT_EQ(session.noise.variance, noise.variance);
  EXPECT_EQ(session.noise.time_s, noise.time_s);
  EXPECT_EQ(session.misfit({}, {}), misfit);
}

TEST_F(SelectEffects, AReferenceFlightMakesThemTheVehicles) {
  const ReferenceFit normal = ReferenceFlights(session.flights(), {}, recordings.fit, recordings.vehicle, 1).fit();
  const auto mass = std::find_if(normal.effects.begin(), normal.effects.end(),
                                 [](const EffectFinding& e) { return e.effect == "mass"; });
  ASSERT_NE(mass, normal.effects.end());
  EXPECT_NEAR(mass->parameters.front().value, selection.value[column("mass")], 1e-6);
  const auto& effects = normal.vehicle.effects;
  EXPECT_TRUE(std::any_of(effects.begin(), effects.end(), [](const EffectSpec& e) { return e.type == "mass"; }));
}

TEST_F(SelectEffects, AGroupThatWasLostComesBackFromItsValue) {
  const int mass = session.catalogue().find("mass");
  const Selection rest = withdraw(session, selection, {mass});
  ASSERT_EQ(rest.find(mass), nullptr);
  const Selection again = with_also(session, rest, {mass}, selection.value);
  EXPECT_NE(again.find(mass), nullptr);
  EXPECT_NEAR(again.value[column("mass")], selection.value[column("mass")], 0.1 * selection.value[column("mass")]);
}

TEST_F(SelectEffects, ReferenceFlightsDoNotHaveWhatOnlyOthersShow) {
  const Recordings good = test::short_flights("", {"multisine"});
  ReferenceFlights reference(test::session_of(good).flights(), {}, good.fit, good.vehicle, 1);
  EXPECT_FALSE(reference.have(session.catalogue(), selection, {session.catalogue().find("mass")}));
  EXPECT_TRUE(std::ranges::none_of(reference.fit().effects, [](const auto& e) { return e.effect == "mass"; }));
}

}  // namespace select_effects_test
}  // namespace gustlab::diagnosis
