#include "report/gate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace gate_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

// eight gusts, the hardest twice the easiest
std::vector<ResultRow> baseline() {
  std::vector<ResultRow> rows;
  for (int k = 1; k <= 8; ++k) {
    ResultRow row{"ci", "crazyflie", "circle", "pid", k, Outcome::completed, 10.0};
    row.rmse_xy_m = row.mae_xy_m = row.p95_xy_m = row.max_xy_m = row.rmse_z_m = 0.1 + 0.0125 * k;
    row.key = "aa";
    rows.push_back(row);
  }
  return rows;
}

// the planar RMSE times `factor`, plus a scatter of this size
std::vector<ResultRow> changed(double factor, double scatter_m = 0.0) {
  std::vector<ResultRow> rows = baseline();
  for (ResultRow& row : rows)
    row.rmse_xy_m = factor * row.rmse_xy_m + scatter_m * std::sin(2.5 * static_cast<double>(row.replicate));
  return rows;
}

TEST(Gate, EqualResultsPassAndAreEquivalent) {
  const GateReport report = gate(baseline(), baseline(), {});
  ASSERT_EQ(report.cells.size(), 1u);
  EXPECT_EQ(report.failures(), 0u);
  EXPECT_EQ(report.cells[0].verdict, "equivalent");
  EXPECT_THAT(to_markdown(report), testing::StartsWith("**passed**: 0 of 1 cells failed"));
}

TEST(Gate, ErrorsOfNothingHaveNoShareToChangeBy) {
  const GateReport report = gate(changed(0.0), changed(0.0), {});
  EXPECT_THAT(to_markdown(report), AllOf(HasSubstr("| 0.0000 | 0.0000 | – | – | equivalent |"), Not(HasSubstr("nan"))));
}

TEST(Gate, SmallRiseInEveryRunFailsBySignificanceAlone) {
  const GateReport report = gate(changed(1.01, 2e-5), baseline(), {});
  EXPECT_EQ(report.failures(), 1u);
  EXPECT_THAT(to_markdown(report),
              AllOf(HasSubstr("crazyflie circle pid: RMSE 0.1578 m, was 0.1562 m: +1.0 %, significant (p = "),
                    Not(HasSubstr("beyond the margin,"))));
  EXPECT_EQ(gate(changed(1.01, 2e-5), baseline(), {.by_test = false}).failures(), 0u);
}

TEST(Gate, RiseThatScattersFailsByTheMarginAlone) {
  const GateReport report = gate(changed(1.05, 0.02), baseline(), {});
  EXPECT_EQ(report.failures(), 1u);
  EXPECT_THAT(report.cells[0].failures.front(), AllOf(HasSubstr("beyond the margin"), Not(HasSubstr("significant"))));
  EXPECT_EQ(gate(changed(1.05, 0.02), baseline(), {.by_margin = false}).failures(), 0u);
}

TEST(Gate, ScatterWithoutARisePassesAndIsNotCalledEquivalent) {
  const GateReport report = gate(changed(0.98, 0.02), baseline(), {});
  EXPECT_EQ(report.failures(), 0u);
  EXPECT_EQ(report.cells[0].verdict, "cannot tell");
}

TEST(Gate, SmallErrorsMayNotGrowEither) {
  auto before = baseline(), rows = baseline();
  for (ResultRow& row : before) row.rmse_xy_m = 0.004;
  for (ResultRow& row : rows) row.rmse_xy_m = 0.0068;
  EXPECT_EQ(gate(rows, before, {}).failures(), 1u);
  // but what rounding may do is nothing
  for (ResultRow& row : rows) row.rmse_xy_m = 0.004 + 1e-6;
  EXPECT_EQ(gate(rows, before, {}).failures(), 0u);
}

// GIVEN a sweep with variants WHEN a cell of one of them is worse THEN the summary says of which
TEST(Gate, CellsOfVariantsAreToldApart) {
  auto before = baseline(), rows = changed(1.05);
  for (auto* all : {&before, &rows})
    for (ResultRow& row : *all) row.experiment = "grid.strength_0.5_mass_-0.2";
  for (ResultRow row : baseline()) {
    row.experiment = "grid.strength_2_mass_0";
    before.push_back(row);
    rows.push_back(row);
  }
  EXPECT_THAT(to_markdown(gate(rows, before, {})),
              AllOf(HasSubstr("- strength_0.5_mass_-0.2: crazyflie circle pid: RMSE "),
                    HasSubstr("| strength_0.5_mass_-0.2: crazyflie circle pid | 8 |"),
                    HasSubstr("| strength_2_mass_0: crazyflie circle pid | 8 |")));
  // a wrong baseline is called by its experiment, however many variants that has
  EXPECT_THAT([&] { gate(rows, baseline(), {}); },
              ThrowsMessage<DataError>(HasSubstr("it is of ci, the sweep of grid (they have no")));
}

TEST(Gate, BetterNeverFailsAndIsSaid) {
  const GateReport report = gate(changed(0.9, 1e-4), baseline(), {});
  EXPECT_EQ(report.failures(), 0u);
  EXPECT_EQ(report.cells[0].verdict, "improved");
}

TEST(Gate, NewCrashFailsWhateverTheRule) {
  auto rows = baseline();
  rows[1].outcome = Outcome::crashed;
  const GateReport report = gate(rows, baseline(), {.by_margin = false, .by_test = false});
  EXPECT_EQ(report.failures(), 1u);
  EXPECT_THAT(report.cells[0].failures.front(), HasSubstr("replicate 2 was completed, now crashed"));
  // a crash that the baseline has is not new
  EXPECT_EQ(gate(rows, rows, {}).failures(), 0u);
}

// GIVEN a baseline whose runs all crashed WHEN those of the sweep do, too THEN nothing is compared, and that does not pass
TEST(Gate, NothingToCompareFails) {
  auto rows = baseline();
  for (ResultRow& row : rows) row.outcome = Outcome::crashed;
  for (const bool allow_extra : {false, true}) {
    const GateReport report = gate(rows, rows, {.allow_extra = allow_extra});
    EXPECT_EQ(report.failures(), 1u);
    EXPECT_THAT(to_markdown(report), AllOf(testing::StartsWith("**failed**: 1 of 1 cells failed"),
                                           HasSubstr("- crazyflie circle pid: nothing is compared (no cell has a run"),
                                           HasSubstr("| **not compared** |")));
  }
  EXPECT_EQ(gate(rows, baseline(), {}).cells[0].verdict, "**worse**");
  // nor are errors that nobody knows compared
  auto unknown = baseline();
  for (ResultRow& row : unknown)
    for (const Metric& metric : tracking_metrics) row.*metric.value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(gate(unknown, unknown, {}).failures(), 1u);
  // a cell that cannot be compared does not fail beside one that can
  for (ResultRow row : baseline()) {
    row.controller = "indi";
    rows.push_back(row);
  }
  EXPECT_EQ(gate(rows, rows, {}).failures(), 0u);
}

TEST(Gate, MissingRowsFailAndExtraOnesUnlessTheyAreAllowed) {
  auto fewer = baseline();
  fewer.pop_back();
  EXPECT_THAT(gate(fewer, baseline(), {}).cells[0].failures.front(), HasSubstr("replicate 8 is missing"));
  EXPECT_THAT(gate(baseline(), fewer, {}).cells[0].failures.front(), HasSubstr("replicate 8 is extra"));
  // their errors rose by nothing, and the verdict was "worse"
  EXPECT_EQ(gate(fewer, baseline(), {}).cells[0].verdict, "**other runs**");
  EXPECT_EQ(gate(baseline(), fewer, {}).cells[0].verdict, "**other runs**");
  EXPECT_EQ(gate(baseline(), fewer, {.allow_extra = true}).failures(), 0u);
}

TEST(Gate, BaselineOfAnotherExperimentIsTheWrongOne) {
  auto other = baseline();
  for (ResultRow& row : other) row.experiment = "table2";
  EXPECT_THAT([&] { gate(baseline(), other, {}); },
              ThrowsMessage<DataError>(HasSubstr("wrong baseline: it is of table2, the sweep of ci")));
}

TEST(Gate, ErrorThatIsNoLongerANumberFails) {
  auto rows = baseline();
  rows[0].rmse_xy_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(gate(rows, baseline(), {}).failures(), 1u);
}

TEST(Gate, LongListsAreCut) {
  std::vector<ResultRow> before, rows;
  for (int k = 0; k < 30; ++k)
    for (ResultRow row : baseline()) {
      row.controller = "c" + std::to_string(k);
      before.push_back(row);
      row.rmse_xy_m *= 1.1;
      rows.push_back(row);
    }
  EXPECT_THAT(to_markdown(gate(rows, before, {})),
              AllOf(HasSubstr("**failed**: 30 of 30 cells"), HasSubstr("- and 10 more")));
}

TEST(Gate, JunitCountsAndEscapes) {
  auto before = baseline();
  for (ResultRow& row : before) row.controller = "a<b";
  auto rows = before;
  rows[0].outcome = Outcome::crashed;
  const std::string text = to_junit(gate(rows, before, {}));
  EXPECT_THAT(text, HasSubstr("tests=\"1\" failures=\"1\""));
  EXPECT_THAT(text, HasSubstr("name=\"crazyflie circle a&lt;b\""));
}

TEST(Gate, MarkdownShowsThePairedChangeOfEachCell) {
  auto rows = changed(1.01);
  for (ResultRow& row : rows) row.key = "bb";
  EXPECT_THAT(to_markdown(gate(rows, baseline(), {})),
              HasSubstr("| crazyflie circle pid | 8 | 0.1562 | 0.1578 | +1.00 |"));
  EXPECT_THAT(to_markdown(gate(rows, baseline(), {})), HasSubstr("| **worse** | changed |"));
}

}  // namespace gate_test
}  // namespace gustlab
