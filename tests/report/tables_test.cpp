#include "report/tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <nlohmann/json.hpp>

namespace gustlab {
namespace {

ResultRow row(const std::string& trajectory, std::int64_t replicate, double rmse_m, Outcome outcome = Outcome::completed) {
  ResultRow result{"small_one", "iris", trajectory, "pid", replicate, outcome, 24.0};
  result.rmse_xy_m = rmse_m;
  result.mae_xy_m = 0.5 * rmse_m;
  result.p95_xy_m = 2.0 * rmse_m;
  result.max_xy_m = 3.0 * rmse_m;
  result.rmse_z_m = 0.25;
  result.key = "00ff";
  return result;
}

const Results results{{row("circle", 1, 0.1), row("circle", 2, 0.2), row("circle", 3, 0.6, Outcome::crashed), row("spiral", 1, 1.0)}, 2.5};

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
  const std::string text = to_table(results, TableFormat::md);
  EXPECT_NE(text.find("| iris | circle | pid | 2/3 | 0.300 ± 0.265 (0.200) |"), std::string::npos) << text;
  EXPECT_NE(text.find("N = 1 to 3 runs, samples from 2.5 s on"), std::string::npos) << text;
  // one run has no deviation
  EXPECT_NE(text.find("| iris | spiral | pid | 1/1 | 1.000 ± – (1.000) |"), std::string::npos) << text;
}

TEST(Tables, CsvHasOneLineForEachCell) {
  const std::string text = to_table(results, TableFormat::csv);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_NE(text.find("small_one,iris,spiral,pid,2.5,1,1,1,,1,0.5,,0.5,"), std::string::npos) << text;
}

TEST(Tables, LatexUsesBooktabsAndSiunitxAndEscapes) {
  Results named = results;
  named.rows[3].controller = "pid_2";
  const std::string text = to_table(named, TableFormat::latex);
  for (const char* part : {"\\toprule", "\\midrule", "\\bottomrule", "\\num{0.300 +- 0.265}", "pid\\_2", "mean $\\pm$ sample"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST(Tables, JsonReadsBack) {
  const auto table = nlohmann::json::parse(to_table(results, TableFormat::json));
  EXPECT_EQ(table["settle_s"], 2.5);
  EXPECT_EQ(table["cells"][0]["completed"], 2);
  EXPECT_NEAR(table["cells"][0]["rmse_xy_m"]["mean"].get<double>(), 0.3, 1e-12);
  EXPECT_TRUE(table["cells"][1]["rmse_xy_m"]["sd"].is_null());
}

}  // namespace
}  // namespace gustlab
