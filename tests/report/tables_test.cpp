#include "report/tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace gustlab {
namespace tables_test {

ResultRow row(const std::string& trajectory, std::int64_t replicate, double rmse_m,
              Outcome outcome = Outcome::completed) {
  ResultRow result{"small_one", "iris", trajectory, "pid", replicate, outcome, 24.0};
  result.rmse_xy_m = rmse_m;
  result.mae_xy_m = 0.5 * rmse_m;
  result.p95_xy_m = 2.0 * rmse_m;
  result.max_xy_m = 3.0 * rmse_m;
  result.rmse_z_m = 0.25;
  result.key = "00ff";
  return result;
}

const Results results{
    {row("circle", 1, 0.1), row("circle", 2, 0.2), row("circle", 3, 0.6, Outcome::crashed), row("spiral", 1, 1.0)},
    2.5};

TEST(Tables, CellsKeepTheirOrderAndCountWhatWasCompleted) {
  const auto cells = aggregate(results.rows);
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0].trajectory, "circle");
  EXPECT_EQ(cells[0].completed, 2u);
  EXPECT_EQ(cells[0].total, 3u);
  EXPECT_DOUBLE_EQ(cells[0].errors[0].mean, 0.3);
  EXPECT_NEAR(cells[0].errors[0].sd, 0.2645751311, 1e-9);
  EXPECT_DOUBLE_EQ(cells[0].errors[0].median, 0.2);
}

TEST(Tables, MarkdownSaysTheSettleWindowAndTheNumberOfRuns) {
  const std::string text = to_table(results, {});
  EXPECT_NE(text.find("| iris | circle | pid | 2/3 | 0.300 ± 0.265 (0.200) |"), std::string::npos) << text;
  EXPECT_NE(text.find("N = 1 to 3 runs, samples from 2.5 s on"), std::string::npos) << text;
  // one run has no deviation
  EXPECT_NE(text.find("| iris | spiral | pid | 1/1 | 1.000 ± – (1.000) |"), std::string::npos) << text;
}

TEST(Tables, NamesAreEscaped) {
  TableOptions options{.names = {{"pid", "a|b\\"}}};
  std::string text = to_table(results, options);
  EXPECT_NE(text.find("| iris | spiral | a\\|b\\\\ | 1/1 |"), std::string::npos) << text;
  options.format = TableFormat::latex;
  text = to_table(results, options);
  EXPECT_NE(text.find(" & a|b\\textbackslash{} & "), std::string::npos) << text;
}

TEST(Tables, CsvHasOneLineForEachCell) {
  const std::string text = to_table(results, {.format = TableFormat::csv});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_NE(text.find("small_one,iris,spiral,pid,2.5,1,1,1,,1,0.5,,0.5,"), std::string::npos) << text;
}

// the layout of the paper's Table II: a block for each trajectory, a line for each controller
TEST(Tables, LatexHasTheLayoutOfThePaper) {
  Results named = results;
  named.rows.push_back(row("circle", 1, 0.05));
  named.rows.back().controller = "pid_2";
  std::stable_sort(named.rows.begin(), named.rows.end(),
                   [](const ResultRow& a, const ResultRow& b) { return a.trajectory < b.trajectory; });
  named.arcs = {{"circle", "24 s, 6.9 m, 1.00 laps"}};
  const std::string text = to_table(named, {.format = TableFormat::latex,
                                            .columns = {0, 2},
                                            .bold_best = true,
                                            .names = {{"circle", "Circle"}, {"pid", "PID"}},
                                            .label = "mine"});
  for (const char* part :
       {"\\label{tab:mine}", "\\begin{tabular}{|c|c|c|c|}", "\\textbf{RMSE$_{xy}$} & \\textbf{P95$_{\\|xy\\|}$} \\\\",
        " & & \\textbf{[m]} & \\textbf{[m]} \\\\",
        "\\multirow{2}{*}{Circle} & PID (2/3) & 0.300 $\\pm$ 0.265 & 0.600 $\\pm$ 0.529 \\\\\n\\cline{2-4}\n & pid\\_2 "
        "& \\textbf{0.050} & \\textbf{0.100} \\\\\n\\hline",
        "mean $\\pm$ sample standard deviation over N = 1 to 3 runs, samples from 2.5 s on. Flown: Circle 24 s, 6.9 m, "
        "1.00 laps."})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

// GIVEN a controller that crashed before its error could grow WHEN the best is bold THEN it is one that flew to the end
TEST(Tables, BestIsNobodyWhoCrashedMoreOften) {
  Results two{{row("circle", 1, 0.01), row("circle", 1, 0.3)}, 2.5, {}};
  two.rows[0].outcome = Outcome::crashed;
  two.rows[1].controller = "slow";
  const std::string text = to_table(two, {.columns = {0}, .bold_best = true});
  EXPECT_NE(text.find("| pid | 0/1 | 0.010 ± – (0.010) |"), std::string::npos) << text;
  EXPECT_NE(text.find("| slow | 1/1 | **0.300 ± –** (0.300) |"), std::string::npos) << text;
}

// GIVEN runs that crashed before samples count WHEN they are in a table THEN it says over how many runs its means are
TEST(Tables, SayHowManyRunsHaveAnError) {
  Results early = results;
  early.rows.push_back(row("spiral", 2, NAN, Outcome::crashed));
  early.rows.push_back(row("spiral", 3, 2.0, Outcome::crashed));
  const std::string text = to_table(early, {.columns = {0}});
  EXPECT_NE(text.find("| iris | spiral | pid | 1/3, n = 2 | 1.500 ± 0.707 (1.500) |"), std::string::npos) << text;
  EXPECT_NE(text.find("| iris | circle | pid | 2/3 |"), std::string::npos) << text;
  EXPECT_NE(text.find("N = 3 runs,"), std::string::npos) << text;
  EXPECT_NE(text.find(" n: so many runs have an error, and means are over these; the others ended before 2.5 s."),
            std::string::npos)
      << text;
  EXPECT_EQ(to_table(results, {}).find(" n: "), std::string::npos);
  EXPECT_NE(to_table(early, {.format = TableFormat::latex}).find(" & pid (1/3, n = 2) & 1.500"), std::string::npos);
  EXPECT_NE(to_table(early, {.format = TableFormat::csv, .columns = {0}}).find(",spiral,pid,2.5,1,3,1.5,"),
            std::string::npos);
  EXPECT_NE(to_table(early, {.format = TableFormat::csv, .columns = {0}}).find(",2\n"), std::string::npos);
}

// GIVEN two controllers that completed alike WHEN one crashed before its errors counted, or has none THEN the other is the best
TEST(Tables, NoCrashIsBetterForComingEarly) {
  Results two{{row("circle", 1, 0.1), row("circle", 2, NAN, Outcome::crashed), row("circle", 1, 0.2),
               row("circle", 2, 0.4, Outcome::crashed)},
              2.5,
              {}};
  for (const std::size_t k : {2u, 3u}) two.rows[k].controller = "late";
  const auto cells = aggregate(two.rows);
  EXPECT_TRUE(is_better(cells[1], cells[0], 0));
  EXPECT_FALSE(is_better(cells[0], cells[1], 0));
  two.rows[0].rmse_xy_m = NAN;
  two.rows[0].mae_xy_m = NAN;
  const std::string text = to_table(two, {.columns = {0}, .bold_best = true});
  EXPECT_NE(text.find("| pid | 1/2, n = 0 | – ± – (–) |"), std::string::npos) << text;
  EXPECT_NE(text.find("| late | 1/2 | **0.300 ± 0.141** (0.300) |"), std::string::npos) << text;
}

TEST(Tables, AxesAreTheirFirstColumns) {
  Results swept = results;
  for (ResultRow& row : swept.rows) row.axes = {{"strength", row.trajectory == "circle" ? "1" : "2"}};
  EXPECT_NE(
      to_table(swept, {.columns = {0}}).find("| strength | vehicle | trajectory | controller | completed | RMSE |\n"),
      std::string::npos);
  EXPECT_NE(to_table(swept, {.columns = {0}}).find("| 2 | iris | spiral | pid | 1/1 | 1.000 ± – (1.000) |"),
            std::string::npos);
  EXPECT_NE(to_table(swept, {.format = TableFormat::csv, .columns = {0}})
                .find("small_one,iris,spiral,pid,2.5,1,1,1,,1,1,2\n"),
            std::string::npos);
}

TEST(Tables, JsonReadsBack) {
  const auto table = nlohmann::json::parse(to_table(results, {.format = TableFormat::json}));
  EXPECT_EQ(table["settle_s"], 2.5);
  EXPECT_EQ(table["cells"][0]["completed"], 2);
  EXPECT_NEAR(table["cells"][0]["rmse_xy_m"]["mean"].get<double>(), 0.3, 1e-12);
  EXPECT_TRUE(table["cells"][1]["rmse_xy_m"]["sd"].is_null());
}

}  // namespace tables_test
}  // namespace gustlab
