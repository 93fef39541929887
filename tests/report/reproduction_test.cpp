#include "report/reproduction.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "simulation/experiment.hpp"

namespace gustlab {
namespace reproduction_test {

using testing::AllOf;
using testing::HasSubstr;

ResultRow run(const std::string& trajectory, const std::string& controller, int replicate, double rmse_m) {
  ResultRow row{"e", "iris", trajectory, controller, replicate, Outcome::completed, 10.0};
  row.rmse_xy_m = row.mae_xy_m = row.p95_xy_m = row.max_xy_m = row.rmse_z_m = rmse_m;
  return row;
}

// b is 0.1 above a in every run; c scatters around a, more than a does
OurTable ours() {
  OurTable table{"table1", "e", "iris", {}};
  for (int k = 1; k <= 10; ++k) {
    const double wave = 0.01 * std::sin(k), noise = 0.2 * std::cos(2.7 * k);
    table.rows.push_back(run("circle", "a", k, 0.3 + wave));
    table.rows.push_back(run("circle", "b", k, 0.4 + wave + 0.001 * std::cos(k)));
    table.rows.push_back(run("circle", "c", k, 0.3 + noise));
  }
  return table;
}

Published published(std::vector<Claim> claims = {}) {
  Published result;
  for (const char* controller : {"a", "b", "c"}) {
    result.rows.push_back({"table1", "circle", controller, {}});
    result.rows.back().figures.fill({8, 0.3, 0.05, 0.3});
  }
  result.claims = std::move(claims);
  return result;
}

Reproduction reproduced(std::vector<Claim> claims = {}) {
  return reproduce(published(std::move(claims)), {ours()},
                   [](const PublishedRow&, std::size_t metric) { return metric == 0 ? Use::fitted : Use::blind; });
}

Claim compare(ClaimKind kind, const std::string& first, const std::string& second, double by = 0.0) {
  return {kind, {"table1", "circle", first}, {"table1", "circle", second}, 0, by, true, "", {}};
}

TEST(Reproduction, CellsCountAsManyRunsAsWerePublished) {
  const Reproduction all = reproduced();
  ASSERT_EQ(all.cells.size(), 12u);
  EXPECT_EQ(all.cells[0].ours.n, 8u);
  EXPECT_EQ(all.cells[0].completed, 8u);
  EXPECT_EQ(all.cells[0].use, Use::fitted);
  EXPECT_EQ(all.cells[1].use, Use::blind);
  const ReproducedCell& b = all.cells[4];
  EXPECT_NEAR(b.ratio(), 4.0 / 3.0, 0.02);
  EXPECT_TRUE(b.within(0.5));
  EXPECT_FALSE(b.within(0.25));
  EXPECT_FALSE(b.within_spread());
  // 0.1 over sqrt(0.05²/8 + a little)
  EXPECT_NEAR(b.z_score(), 5.6, 0.3);
}

TEST(Reproduction, ClaimsAreJudgedByPairs) {
  const Reproduction all = reproduced({compare(ClaimKind::less, "a", "b"), compare(ClaimKind::less, "b", "a"),
                                       compare(ClaimKind::less, "a", "c"), compare(ClaimKind::steadier, "a", "c"),
                                       compare(ClaimKind::steadier, "c", "a")});
  ASSERT_EQ(all.claims.size(), 5u);
  EXPECT_EQ(all.claims[0].verdict, Verdict::pass);
  EXPECT_LT(all.claims[0].p_value, 1e-6);
  EXPECT_EQ(all.claims[0].n, 8u);
  EXPECT_EQ(all.claims[1].verdict, Verdict::fail);
  EXPECT_EQ(all.claims[2].verdict, Verdict::not_significant);
  EXPECT_EQ(all.claims[3].verdict, Verdict::pass);
  EXPECT_EQ(all.claims[4].verdict, Verdict::fail);
  // the paper's own figures are alike
  EXPECT_NEAR(all.claims[0].paper_p_value, 1.0, 1e-9);
}

// GIVEN claims that hold WHEN the same is flown in still air, where b is ahead of c THEN only what does not hold there needs the gust
TEST(Reproduction, ClaimsSayWhetherTheyNeedTheGust) {
  OurTable table = ours();
  for (ResultRow row : table.rows) {
    row.rmse_xy_m = row.controller == "a" ? 0.2 : row.controller == "b" ? 0.25 : 0.15;
    table.still.push_back(row);
  }
  for (ResultRow& row : table.rows)
    if (row.controller == "c") row.rmse_xy_m = 0.5 + 0.001 * std::cos(static_cast<double>(row.replicate));
  const auto use = [](const PublishedRow&, std::size_t) { return Use::blind; };
  const Reproduction all =
      reproduce(published({compare(ClaimKind::less, "a", "b"), compare(ClaimKind::less, "a", "c")}), {table}, use);
  EXPECT_EQ(all.claims[0].still, Verdict::pass);
  EXPECT_FALSE(all.claims[0].needs_gust());
  EXPECT_EQ(all.claims[1].still, Verdict::fail);
  EXPECT_TRUE(all.claims[1].needs_gust());
  EXPECT_DOUBLE_EQ(all.cells[0].still_m, 0.2);
  EXPECT_NEAR(all.cells[0].gust_share(), 1.0 / 3.0, 0.01);
  EXPECT_THAT(to_markdown(all, {table}), AllOf(HasSubstr("| 0.200 | 34 % |"), HasSubstr("| fail | yes |")));
}

// GIVEN runs that are all alike WHEN they are compared THEN there is an order and no p-value
TEST(Reproduction, NothingIsTestedWhereNothingScatters) {
  OurTable table{"table1", "e", "iris", {}};
  for (int k = 1; k <= 8; ++k) {
    table.rows.push_back(run("circle", "a", k, 0.3));
    table.rows.push_back(run("circle", "b", k, 0.4));
  }
  const Reproduction all = reproduce(published({compare(ClaimKind::less, "a", "b")}), {table},
                                     [](const PublishedRow&, std::size_t) { return Use::blind; });
  EXPECT_EQ(all.claims[0].verdict, Verdict::pass);
  EXPECT_TRUE(std::isnan(all.claims[0].p_value));
}

TEST(Reproduction, ReductionsMustReachTheirShare) {
  const Reproduction all =
      reproduced({compare(ClaimKind::reduced, "a", "b", 0.2), compare(ClaimKind::reduced, "a", "b", 0.6)});
  EXPECT_EQ(all.claims[0].verdict, Verdict::pass);
  EXPECT_EQ(all.claims[1].verdict, Verdict::fail);
  EXPECT_THAT(all.claims[1].claim, HasSubstr("a 60 % below b, ours 25 %"));
}

TEST(Reproduction, RunawaysAndCrashesAreCounted) {
  OurTable table = ours();
  const std::vector<Claim> claims{{ClaimKind::runaway, {"table1", "", "a"}, {}, 3, 0.0, true, "", {}},
                                  {ClaimKind::completion, {"table1", "", "a"}, {}, 0, 0.0, true, "", {}},
                                  {ClaimKind::completion, {"table1", "", "a"}, {}, 0, 0.0, false, "", {}}};
  const auto use = [](const PublishedRow&, std::size_t) { return Use::blind; };
  Reproduction all = reproduce(published(claims), {table}, use);
  EXPECT_EQ(all.claims[0].verdict, Verdict::fail);
  EXPECT_EQ(all.claims[1].verdict, Verdict::pass);
  EXPECT_EQ(all.claims[2].verdict, Verdict::fail);
  table.rows[3].max_xy_m = 5.0;
  table.rows[3].outcome = Outcome::crashed;
  all = reproduce(published(claims), {table}, use);
  EXPECT_EQ(all.claims[0].verdict, Verdict::pass);
  EXPECT_EQ(all.claims[1].verdict, Verdict::fail);
}

// GIVEN another experiment in a table's place, with one controller fewer WHEN it is reported THEN every run of it counts
TEST(Reproduction, OtherExperimentsCountEveryRunAndNeedNotFlyEveryController) {
  OurTable table = ours();
  table.all_replicates = true;
  std::erase_if(table.rows, [](const ResultRow& row) { return row.controller == "c"; });
  const std::vector<Claim> claims{compare(ClaimKind::less, "a", "b"),
                                  compare(ClaimKind::less, "a", "c"),
                                  compare(ClaimKind::steadier, "c", "a"),
                                  {ClaimKind::completion, {"table1", "", "c"}, {}, 0, 0.0, true, "", {}}};
  const Reproduction all =
      reproduce(published(claims), {table}, [](const PublishedRow&, std::size_t) { return Use::blind; });
  EXPECT_EQ(all.cells.size(), 8u);
  EXPECT_EQ(all.cells[0].ours.n, 10u);
  ASSERT_EQ(all.claims.size(), 1u);
  EXPECT_EQ(all.claims[0].n, 10u);
}

// GIVEN 100 runs, of which one in ten ruins the mean of the 8 it is drawn with WHEN tables of 8 are drawn THEN as many are near as have none
TEST(Reproduction, TablesDrawnFromManyRunsSayHowNearAsFewRunsCome) {
  OurTable table{"table1", "e", "iris", {}, true};
  for (int k = 1; k <= 100; ++k) {
    table.rows.push_back(run("circle", "a", k, k % 10 == 0 ? 3.0 : 0.3));
    table.rows.push_back(run("circle", "b", k, 0.42));
  }
  const auto use = [](const PublishedRow&, std::size_t) { return Use::blind; };
  const Reproduction all = reproduce(published(), {table}, use);
  ASSERT_EQ(all.drawn.size(), 1u);
  const DrawnTables& drawn = all.drawn[0];
  EXPECT_EQ(drawn.gusts, 100u);
  EXPECT_EQ(drawn.runs, 8u);
  // 0.9⁸ of the tables have a's four means; b's are 40 % off in all; one draw for all cells: four or none
  EXPECT_NEAR(drawn.within_25.expected, 4.0 * std::pow(0.9, 8), 0.06);
  EXPECT_EQ(drawn.within_25.low, 0.0);
  EXPECT_EQ(drawn.within_25.high, 4.0);
  EXPECT_NEAR(drawn.within_50.expected, 4.0 + drawn.within_25.expected, 1e-12);
  EXPECT_THAT(to_markdown(all, {table}), HasSubstr("| table1: 8 of 100 gusts | 1.7 | 0 to 4 | 5.7 | 4 to 8 |"));
  EXPECT_EQ(nlohmann::json::parse(to_json(all))["drawn_tables"][0]["within_50_percent"]["high"], 8.0);
  // where as many runs count as were published there is nothing to draw
  EXPECT_TRUE(reproduced().drawn.empty());
}

TEST(Reproduction, TablesThatWereNotFlownLeaveOutTheirClaims) {
  Claim other = compare(ClaimKind::less, "a", "b");
  other.first.table = other.second.table = "table2";
  EXPECT_TRUE(reproduced({other}).claims.empty());
  EXPECT_THAT(to_svg({}), HasSubstr("no runs"));
}

TEST(Reproduction, SaysTheSameInEveryForm) {
  const Reproduction all = reproduced({compare(ClaimKind::less, "a", "b")});
  const auto json = nlohmann::json::parse(to_json(all));
  ASSERT_EQ(json["cells"].size(), 12u);
  EXPECT_EQ(json["cells"][0]["use"], "fitted");
  EXPECT_EQ(json["cells"][0]["metric"], "rmse_xy_m");
  EXPECT_EQ(json["claims"][0]["verdict"], "pass");
  EXPECT_EQ(json["counts"]["within_50_percent"], 12);
  const std::string markdown = to_markdown(all, {ours()});
  EXPECT_THAT(markdown, HasSubstr("| table1 | circle RMSE: a < b | pass | < 0.001 | 8 | 1.000 | – | – |"));
  EXPECT_THAT(markdown, HasSubstr("| circle | b | RMSE | 0.300 ± 0.050 | 0.4"));
  EXPECT_THAT(to_svg(all), testing::StartsWith("<svg xmlns="));
  EXPECT_THAT(to_svg(all), AllOf(HasSubstr("ours, m, N = 8 runs"), HasSubstr("paper, m, N = 8 runs")));
}

TEST(Published, HoldsThePapers96MeansAndRefusesOthers) {
  const Published paper = read_published(find_experiment("published_tables"));
  EXPECT_EQ(paper.rows.size() * published_metrics.size(), 96u);
  EXPECT_EQ(paper.find("table1", "spiral", "pid")->figures[3].mean, 6.335);
  EXPECT_EQ(paper.find("table3", "lemniscate", "asindy")->figures[0].n, 4u);
  EXPECT_GT(paper.claims.size(), 60u);
}

}  // namespace reproduction_test
}  // namespace gustlab
