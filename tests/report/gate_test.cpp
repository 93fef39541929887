#include "report/gate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gustlab {
namespace {

using testing::HasSubstr;

std::vector<ResultRow> baseline() {
  std::vector<ResultRow> rows;
  for (int k = 1; k <= 4; ++k) {
    ResultRow row{"ci", "crazyflie", "circle", "pid", k, Outcome::completed, 10.0};
    row.rmse_xy_m = row.mae_xy_m = row.p95_xy_m = row.max_xy_m = row.rmse_z_m = 0.1 * k;
    row.key = "aa";
    rows.push_back(row);
  }
  return rows;
}

constexpr GateTolerance tolerance{.absolute_m = 0.002, .relative = 0.05};

TEST(Gate, EqualResultsPass) {
  const GateReport report = gate(baseline(), baseline(), tolerance);
  EXPECT_EQ(report.cases.size(), 4u);
  EXPECT_EQ(report.failures(), 0u);
  EXPECT_THAT(to_markdown(report), HasSubstr("**passed**: 4 runs"));
}

TEST(Gate, WorseThanBothTolerancesFailsAndNamesTheRunAndTheMetric) {
  auto rows = baseline();
  rows[2].p95_xy_m = 0.3 * 1.06;
  const GateReport report = gate(rows, baseline(), tolerance);
  EXPECT_EQ(report.failures(), 1u);
  EXPECT_THAT(to_markdown(report), HasSubstr("crazyflie circle pid replicate 3: P95 0.3180 m, was 0.3000 m"));
  rows[2].p95_xy_m = 0.3 * 1.04;
  EXPECT_EQ(gate(rows, baseline(), tolerance).failures(), 0u);
}

TEST(Gate, AbsoluteToleranceCoversSmallErrors) {
  auto before = baseline(), rows = baseline();
  before[0].rmse_xy_m = 0.001;
  rows[0].rmse_xy_m = 0.0029;
  EXPECT_EQ(gate(rows, before, tolerance).failures(), 0u);
  rows[0].rmse_xy_m = 0.0031;
  EXPECT_EQ(gate(rows, before, tolerance).failures(), 1u);
}

TEST(Gate, BetterNeverFails) {
  auto rows = baseline();
  for (ResultRow& row : rows) row.rmse_xy_m = 0.0;
  EXPECT_EQ(gate(rows, baseline(), tolerance).failures(), 0u);
}

TEST(Gate, NewCrashFailsWhateverTheTolerance) {
  auto rows = baseline();
  rows[1].outcome = Outcome::crashed;
  const GateReport report = gate(rows, baseline(), {.absolute_m = 1e9, .relative = 1e9});
  EXPECT_EQ(report.failures(), 1u);
  EXPECT_THAT(report.cases[1].failure, HasSubstr("was completed, now crashed"));
  // a crash that the baseline has is not new
  EXPECT_EQ(gate(rows, rows, tolerance).failures(), 0u);
}

TEST(Gate, MissingAndExtraRowsFail) {
  auto fewer = baseline();
  fewer.pop_back();
  EXPECT_THAT(gate(fewer, baseline(), tolerance).cases[3].failure, HasSubstr("missing"));
  EXPECT_EQ(gate(fewer, baseline(), tolerance).failures(), 1u);
  EXPECT_THAT(gate(baseline(), fewer, tolerance).cases[3].failure, HasSubstr("extra"));
  EXPECT_EQ(gate(baseline(), fewer, tolerance).failures(), 1u);
}

TEST(Gate, ErrorThatIsNoLongerANumberFails) {
  auto rows = baseline();
  rows[0].rmse_xy_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(gate(rows, baseline(), tolerance).failures(), 1u);
}

TEST(Gate, JunitCountsAndEscapes) {
  auto rows = baseline();
  rows[0].controller = "a<b";
  const std::string text = to_junit(gate(rows, baseline(), tolerance));
  EXPECT_THAT(text, HasSubstr("tests=\"5\" failures=\"2\""));
  EXPECT_THAT(text, HasSubstr("classname=\"crazyflie circle a&lt;b\""));
}

TEST(Gate, MarkdownShowsThePairedChangeOfEachCell) {
  auto rows = baseline();
  for (ResultRow& row : rows) {
    row.rmse_xy_m += 0.001;
    row.key = "bb";
  }
  EXPECT_THAT(to_markdown(gate(rows, baseline(), tolerance)),
              HasSubstr("| crazyflie circle pid | 4 | 0.2500 | 0.2510 | +0.0010 |"));
  EXPECT_THAT(to_markdown(gate(rows, baseline(), tolerance)), HasSubstr("| changed |"));
}

}  // namespace
}  // namespace gustlab
