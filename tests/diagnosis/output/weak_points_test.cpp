// Why a candidate has no name, in words from its record.
#include "diagnosis/output/weak_points.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "diagnosis/evidence/judge.hpp"

namespace gustlab::diagnosis {
namespace weak_points_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// everything speaks for it
Evidence strong() {
  Evidence e;
  e.delta_chi2 = 2000.0;
  e.held_out_delta_chi2 = 600.0, e.held_out_expected = 650.0;
  e.surrogates = {1.1, 0.005, true};
  e.flights = {{"a", false, 1.0, 0.05}, {"b", false, 1.1, 0.05}, {"held out", true, 0.95, 0.05}};
  e.size_in_tolerances = 5.0, e.inclusion = 1.0;
  e.recovered = {0.2, 0.3, 0.3}, e.recovered_z = {5.0, 8.0, 8.0};
  return e;
}

std::vector<std::string> points(Evidence e) {
  judge(e);
  return weak_points(e);
}

TEST(WeakPoints, OfWhatIsNamedAreNone) { EXPECT_THAT(points(strong()), IsEmpty()); }

TEST(WeakPoints, OfARecordThatWasNotJudgedAreNone) { EXPECT_THAT(weak_points(Evidence{}), IsEmpty()); }

TEST(WeakPoints, OneThatSpeaksAgainstItIsTheFirst) {
  const auto first = [](const std::function<void(Evidence&)>& worsen) {
    Evidence e = strong();
    // a little less sure, so that one weakness is enough
    e.size_in_tolerances = 2.0, e.inclusion = 0.2;
    worsen(e);
    const std::vector<std::string> all = points(e);
    return all.empty() ? "" : all.front();
  };
  EXPECT_THAT(first([](Evidence& e) { e.surrogates.p_value = 0.8; }), "moved along the flight it fits as well");
  EXPECT_THAT(first([](Evidence& e) { e.surrogates.p_value = 0.13; }),
              "moved along the flight it fits as well in 13 % of the cases");
  EXPECT_THAT(first([](Evidence& e) { e.held_out_delta_chi2 = -700.0; }), "it does not help on the held-out flights");
  EXPECT_THAT(first([](Evidence& e) { e.recovered[1] = -0.3, e.recovered_z[1] = -5.0; }),
              "simulated 0.5 s ahead, the held-out flights are predicted worse with it");
  EXPECT_THAT(first([](Evidence& e) { e.sensors_share = 0.0; }), HasSubstr("leave no room for it"));
  EXPECT_THAT(first([](Evidence& e) { e.at_bound = true; }), HasSubstr("limit of what is allowed"));
  EXPECT_THAT(first([](Evidence& e) { e.alike = 1; }), HasSubstr("two at once are rare"));
  EXPECT_THAT(first([](Evidence& e) { e.lone_latency = true; }), HasSubstr("one reference flight alone"));
  EXPECT_THAT(first([](Evidence& e) { e.slow_speeds_delta_chi2 = -14.0; }), HasSubstr("not that late"));
  EXPECT_THAT(first([](Evidence& e) { e.between_rows_delta_chi2 = -25.0; }), HasSubstr("falls until the next row"));
  EXPECT_THAT(first([](Evidence& e) { e.undone = 0.97; }), "the other names take back 97 % of what it does");
  EXPECT_THAT(first([](Evidence& e) { e.dwarfed_by = 9000.0; }),
              HasSubstr("another name does 95 times as much where it shows"));
  EXPECT_THAT(first([](Evidence& e) { e.outweighed = 4.16; }),
              "the other names do 4.2 times as much against it as it does");
  EXPECT_THAT(first([](Evidence& e) { e.force_excess = -0.63, e.part_lacking = 0.63; }),
              "its push is 63 % smaller than its turn says");
  EXPECT_THAT(first([](Evidence& e) { e.force_over_tilt = 0.2; }), HasSubstr("an attitude that is a little off"));
  EXPECT_THAT(first([](Evidence& e) { e.unpredicted_commands = 3000.0; }), HasSubstr("commands that the log does not"));
  EXPECT_THAT(first([](Evidence& e) { e.rival_z = 1.0; }), "another name explains nearly the same");
}

TEST(WeakPoints, OfASmallGainSayWhy) {
  Evidence e = strong();
  e.delta_chi2 = 12.0;
  EXPECT_THAT(points(e), Contains("the flights are hardly likelier with it"));
  e = strong();
  e.delta_chi2_with_partner = 12.0;
  EXPECT_THAT(points(e), Contains(HasSubstr("it and another name undo each other")));
  e = strong();
  e.clustered_inflation = 200.0;
  EXPECT_THAT(points(e), Contains("its size changes from one part of a flight to the next"));
  e.surrogates.inflation = 300.0;
  EXPECT_THAT(points(e), Contains(HasSubstr("moved along the flight it gains a large part")));
}

// a force of each flight, or one that changes along it, may well predict held-out flights far better
TEST(WeakPoints, OfWhatPredictsButDoesNotRepeatSayNothingOfPredictions) {
  Evidence e;
  e.features = {{"predicts", 0.0}}, e.probability = 0.6;
  e.recovered = {0.5, 0.7, 0.7}, e.recovered_z = {9.0, 20.0, 20.0};
  e.uneven = 0.2;
  EXPECT_THAT(weak_points(e), ElementsAre("its size changes from one part of a flight to the next"));
  e.per_flight = true;
  EXPECT_THAT(weak_points(e), ElementsAre(HasSubstr("each flight has its own values of it")));
}

TEST(WeakPoints, AreTheHeaviestThreeAtMostAndEachOnce) {
  Evidence e = strong();
  e.per_flight = true, e.alike = 1, e.at_bound = true, e.sensors_share = 0.0, e.undone = 1.0;
  const std::vector<std::string> all = points(e);
  EXPECT_THAT(all, SizeIs(3));
  EXPECT_THAT(all.front(), HasSubstr("leave no room"));
  // flights, flights_alike and held_out of values that belong to each flight are one reason
  Evidence own;
  own.features = {{"flights", 0.0}, {"flights_alike", 0.0}, {"held_out", 0.0}};
  own.per_flight = true, own.probability = 0.01;
  EXPECT_THAT(weak_points(own), SizeIs(1));
}

// a feature without words would be silent
TEST(WeakPoints, EveryFeatureOfTheJudgeHasWords) {
  Evidence e = strong();
  judge(e);
  for (const auto& [name, value] : std::vector(e.features)) {
    EXPECT_GT(weight_of(name), 0.0) << name;
    e.features = {{name, 0.0}}, e.probability = 0.01;
    // what weighs little is not worth a word alone
    EXPECT_EQ(weak_points(e).size(), weight_of(name) < 0.25 ? 0u : 1u) << name;
  }
  EXPECT_EQ(weight_of("courage"), 0.0);
  EXPECT_EQ(in_one_clause({"a", "b"}), "a; b");
}

}  // namespace weak_points_test
}  // namespace gustlab::diagnosis
