#include "report/compare.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace compare_test {

ResultRow row(const std::string& controller, std::int64_t replicate, double rmse_m,
              Outcome outcome = Outcome::completed) {
  ResultRow result{"e.v", "iris", "circle", controller, replicate, outcome, 10.0};
  result.rmse_xy_m = rmse_m;
  result.rotor_sd_radps = 40.0;
  result.rotor_rate_radps2 = 900.0;
  return result;
}

// 40 gusts, each of its own strength; `crashes` of the runs of b are not completed
NamedResults variant(const std::string& name, double a_m, double b_m, double c_m, int crashes = 0) {
  NamedResults named{name, {}};
  for (int k = 0; k < 40; ++k) {
    const double gust = 0.05 * std::sin(2.0 * k), noise = 0.001 * std::cos(7.0 * k);
    named.results.rows.push_back(row("a", k, a_m + gust));
    named.results.rows.push_back(row("b", k, b_m + gust + noise, k < crashes ? Outcome::crashed : Outcome::completed));
    named.results.rows.push_back(row("c", k, c_m + gust - noise));
  }
  return named;
}

// the gusts differ by ten times more than the controllers: only pairs can tell
TEST(Compare, TellsTheBestByPairs) {
  const auto compared = compare(std::vector{variant("nominal", 0.105, 0.100, 0.1001)}, 0.5);
  ASSERT_EQ(compared.size(), 1u);
  EXPECT_EQ(compared[0].controllers[compared[0].best].name, "b");
  EXPECT_FALSE(compared[0].controllers[0].as_good_as_best);
  EXPECT_NEAR(compared[0].controllers[0].behind_m, 0.005, 0.0005);
  EXPECT_GT(compared[0].controllers[0].behind.low, 0.004);
  EXPECT_TRUE(compared[0].controllers[2].as_good_as_best);
}

TEST(Compare, CallsBrokenWhatCrashesOrFliesFarAway) {
  const auto compared = compare(std::vector{variant("nominal", 0.2, 0.1, 0.3), variant("crash", 0.2, 0.1, 0.3, 3),
                                            variant("far", 0.39, 9.44, 0.3)},
                                0.5);
  for (const ComparedController& controller : compared[0].controllers) EXPECT_FALSE(controller.broken);
  // 37 of 40 are fewer than 95 %, and one that crashes is not the best, however near it flies
  EXPECT_TRUE(compared[1].controllers[1].broken);
  EXPECT_EQ(compared[1].controllers[1].completed, 37u);
  EXPECT_EQ(compared[1].controllers[compared[1].best].name, "a");
  EXPECT_FALSE(compared[1].controllers[1].as_good_as_best);
  // nearly twice its error in nominal is within the limit
  EXPECT_FALSE(compared[2].controllers[0].broken);
  EXPECT_TRUE(compared[2].controllers[1].broken);
  EXPECT_EQ(compared[2].controllers[1].completed, 40u);
  EXPECT_EQ(compared[2].controllers[1].held, 0u);
}

// trajectories share their gusts: ten of them are still four gusts, and no interval gets narrower by copies
TEST(Compare, ResamplesGustsNotRuns) {
  const auto flown = [](int copies) {
    NamedResults named{"nominal", {}};
    for (const char* controller : {"a", "b"})
      for (int copy = 0; copy < copies; ++copy)
        for (int gust = 0; gust < 12; ++gust) {
          named.results.rows.push_back(
              row(controller, gust, *controller == 'a' ? 0.1 : 0.11 + 0.01 * std::sin(2.0 * gust)));
          named.results.rows.back().trajectory = "t" + std::to_string(copy);
        }
    return compare(std::vector{named}, 0.5)[0].controllers[1].behind;
  };
  EXPECT_NEAR(flown(10).low, flown(1).low, 1e-12);
  EXPECT_NEAR(flown(10).high, flown(1).high, 1e-12);
}

TEST(Compare, SaysItInMarkdown) {
  const std::string text = to_markdown(
      compare(std::vector{variant("nominal", 0.2, 0.1, 0.3), variant("crash", 0.2, 0.1, 0.3, 3)}, 0.5), 0.5);
  EXPECT_THAT(text, testing::HasSubstr("a planar RMSE of at most 0.5 m"));
  EXPECT_THAT(text, testing::HasSubstr("| nominal | 0.20"));
  EXPECT_THAT(text, testing::HasSubstr("(37/40) † |"));
  EXPECT_THAT(text,
              testing::HasSubstr(
                  "| a | 40 | 900 | crash | – |\n| b | 40 | 900 | nominal | crash |\n| c | 40 | 900 | – | – |\n"));
}

// GIVEN an axis whose points were flown alone WHEN a controller breaks and holds again THEN its margin is the last value before it first broke
TEST(Compare, MarginIsTheLastValueBeforeTheFirstThatBreaks) {
  std::vector<NamedResults> flown{variant("nominal", 0.2, 0.1, 0.3)};
  for (const auto& [value, a_m, b_m] : std::vector<std::tuple<std::string, double, double>>{
           {"0.1", 0.2, 0.2}, {"0.2", 0.9, 0.2}, {"0.3", 0.2, 0.9}, {"0.4", 0.2, 0.9}}) {
    flown.push_back(variant("late_" + value, a_m, b_m, value == "0.4" ? 0.9 : 0.3));
    flown.back().alone = {"late", value};
  }
  flown.push_back(variant("gain_2", 0.9, 0.2, 0.3));
  flown.back().alone = {"gain", "2"};
  const auto compared = compare(flown, 0.5);
  const auto margins = margins_of(compared);
  ASSERT_EQ(margins.size(), 2u);
  EXPECT_EQ(margins[0].held, (std::vector<std::size_t>{1, 2, 3}));
  const std::string text = to_markdown(compared, 0.5);
  EXPECT_THAT(text, testing::HasSubstr("| late | 0.1 | 0.2 | 0.3 | 0.1, 0.2, 0.3, 0.4 |"));
  EXPECT_THAT(text, testing::HasSubstr("| gain | – | ≥ 2 | ≥ 2 | 2 |"));
}

// GIVEN a variant in which no controller holds a run WHEN it is compared THEN none is called best, and bold
TEST(Compare, NobodyIsBestWhereNobodyHeld) {
  const auto compared = compare(std::vector{variant("far", 0.9, 0.8, 0.7)}, 0.5);
  for (const ComparedController& controller : compared[0].controllers) EXPECT_FALSE(controller.as_good_as_best);
  const std::string text = to_markdown(compared, 0.5);
  EXPECT_THAT(text, testing::HasSubstr("(0/40) † | – | – |"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("**")));
  EXPECT_THAT(to_json(compared, 0.5), testing::HasSubstr("\"best\": null"));
}

// GIVEN errors that count from 3 s on WHEN variants are compared THEN the caption says so, and no other time is mixed in
TEST(Compare, SaysFromWhenOnSamplesCount) {
  std::vector<NamedResults> variants{variant("nominal", 0.2, 0.1, 0.3), variant("late", 0.2, 0.1, 0.3)};
  for (NamedResults& named : variants) named.results.settle_s = 3.0;
  const auto compared = compare(variants, 0.5);
  EXPECT_THAT(to_markdown(compared, 0.5), testing::HasSubstr("Mean planar RMSE in m, samples from 3 s on, over"));
  EXPECT_THAT(to_json(compared, 0.5), testing::HasSubstr("\"settle_s\": 3.0"));
  variants[1].results.settle_s = 0.5;
  EXPECT_THAT([&] { compare(variants, 0.5); },
              testing::ThrowsMessage<DataError>(testing::HasSubstr("nominal and late settle for 3 s and for 0.5 s")));
}

TEST(Compare, NeedsTheSameRuns) {
  std::vector<NamedResults> variants{variant("nominal", 0.2, 0.1, 0.3), variant("less", 0.2, 0.1, 0.3)};
  variants[1].results.rows.erase(variants[1].results.rows.begin() + 117, variants[1].results.rows.end());
  EXPECT_THAT([&] { compare(variants, 0.5); },
              testing::ThrowsMessage<DataError>(testing::HasSubstr("nominal and less do not have the same")));
  variants[1].results.rows.pop_back();
  EXPECT_THROW(compare(variants, 0.5), DataError);
}

}  // namespace compare_test
}  // namespace gustlab
