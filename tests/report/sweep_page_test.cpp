#include "report/sweep_page.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <regex>

#include "report/page_checks.hpp"

namespace gustlab {
namespace sweep_page_test {

using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

// strength × mass × two controllers on two trajectories, five runs each; the better controller fails at the strongest gust
Results grid() {
  Results results;
  results.settle_s = 2.0;
  results.axis_units = {{"strength", "m/s^2"}, {"mass", "-"}};
  for (const char* strength : {"0", "0.5", "1", "2"})
    for (const char* mass : {"-0.2", "0", "0.2"})
      for (const char* trajectory : {"circle", "lemniscate"})
        for (const char* controller : {"pid", "indi"})
          for (int replicate = 1; replicate <= 5; ++replicate) {
            ResultRow row;
            row.experiment = std::string("grid.strength_") + strength + "_mass_" + mass;
            row.vehicle = "crazyflie", row.trajectory = trajectory, row.controller = controller;
            row.replicate = replicate, row.duration_s = 15.0;
            const bool indi = row.controller == "indi";
            row.rmse_xy_m = (indi ? 0.05 : 0.1) * (1.0 + std::stod(strength)) + 0.001 * replicate;
            row.mae_xy_m = row.p95_xy_m = row.max_xy_m = row.rmse_z_m = row.rmse_xy_m;
            if (indi && std::string(strength) == "2" && replicate == 3)
              row.outcome = Outcome::crashed, row.duration_s = 4.25;
            row.axes = {{"strength", strength}, {"mass", mass}};
            results.rows.push_back(row);
          }
  return results;
}

SweepFigures round_paths() {
  SweepFigures figures;
  for (const char* controller : {"pid", "indi"}) {
    SweptPath path{"circle", controller, {}, {}, {}, {}};
    for (int k = 0; k <= 100; ++k) {
      const double angle = 0.0628 * k, radius = path.controller == "pid" ? 1.1 : 1.02;
      path.x_m.push_back(radius * std::cos(angle)), path.y_m.push_back(radius * std::sin(angle));
      path.reference_x_m.push_back(std::cos(angle)), path.reference_y_m.push_back(std::sin(angle));
    }
    figures.paths.push_back(path);
  }
  figures.paths_of = "Replicate 1 of strength_1_mass_0: all met the same gust.";
  return figures;
}

TEST(SweepPage, SaysWhoIsBestWhatFailedAndWhere) {
  const std::string html = sweep_page(grid(), round_paths());
  expect_sound(html);
  EXPECT_EQ(html, sweep_page(grid(), round_paths()));
  std::size_t at = 0;
  for (const char* wanted :
       {"<title>Sweep grid</title>", "Sweep grid · crazyflie · 240 runs · strength: 4 values · mass: 3 values",
        // not where it crashed in one of five runs: six of the 24, in which its errors are the least all the same
        "indi is best in 18 of 24 comparisons.", "6 of 240 runs were not completed", "Best: most runs completed",
        "All 48 cells", "Heat map", "indi, lemniscate", "mass [–] \\ strength [m/s²]", "Over strength",
        ">strength [m/s²]</text>", "Shown at mass = 0.", "Over mass", ">mass [–]</text>", "Shown at strength = 1 m/s².",
        "Paths", "Replicate 1 of strength_1_mass_0", "What was not completed",
        "circle, strength = 2 m/s², mass = -0.2</td><td data-label=\"controller\">indi</td><td data-label=\"how it "
        "ended\">crashed</td><td data-label=\"runs\" class=\"n\">1 of 5</td><td data-label=\"the earliest\" "
        "class=\"n\">4.25 s, replicate 3"}) {
    const std::size_t found = html.find(wanted, at);
    ASSERT_NE(found, std::string::npos) << wanted;
    at = found;
  }
}

TEST(SweepPage, HeatIsTheMeanOverTheLargest) {
  // pid at strength 2: 0.303 m is the largest mean; indi in still air: 0.053 m
  const std::string html = sweep_page(grid(), {});
  EXPECT_THAT(html, HasSubstr("<td style=\"--heat:1.000\">0.303</td>"));
  EXPECT_THAT(html, HasSubstr("<td style=\"--heat:0.175\">0.053</td>"));
  EXPECT_THAT(html, HasSubstr("gustlab sweep --logs"));
  EXPECT_THAT(html, HasSubstr("MAE its mean, 95&#160;% of the samples are below P95"));
}

TEST(SweepPage, WithoutAxesTrajectoriesStandBesideControllers) {
  Results results = grid();
  std::erase_if(results.rows, [](const ResultRow& row) { return row.experiment != "grid.strength_1_mass_0"; });
  for (ResultRow& row : results.rows) row.experiment = "plain", row.axes.clear();
  results.rows.front().rmse_xy_m = NAN;
  const std::string html = sweep_page(results, {});
  expect_sound(html);
  EXPECT_THAT(html, HasSubstr("<th class=\"n\">circle</th><th class=\"n\">lemniscate</th>"));
  EXPECT_THAT(html, Not(HasSubstr("Over ")));
  EXPECT_THAT(html, HasSubstr("Every run was completed."));
  EXPECT_THAT(html, Not(HasSubstr("What was not completed")));
  EXPECT_THAT(html, Not(HasSubstr("how many runs were completed")));
}

TEST(SweepPage, EscapesNames) {
  Results results = grid();
  for (ResultRow& row : results.rows) row.controller = "<b>" + row.controller, row.axes[0].name = "<i>";
  const std::string html = sweep_page(results, round_paths());
  EXPECT_THAT(html, AllOf(Not(HasSubstr("<b>")), Not(HasSubstr("<i>"))));
}

// what a phone's width alone makes too wide is seen there, and is none at a desk
TEST(PageChecks, SeeWhatIsTooWideForAPhone) {
  if (!chromium_is_here()) GTEST_SKIP() << "chromium is not installed: layout not looked at";
  const std::string html =
      "<!doctype html><html><head></head><body><main><p style=\"width:450px\">wide</p></main></body></html>";
  EXPECT_THAT(misfits(html, 375), HasSubstr("wider than the page: &lt;p style"));
  EXPECT_EQ(misfits(html, 1200), "");
}

// "0.006 ± 0.000"; on a phone the bar stood alone
TEST(SweepPage, ASpreadHasADigitAndTheBarATitle) {
  Results results = grid();
  for (ResultRow& row : results.rows) row.rmse_z_m = 0.006 + 2e-5 * row.replicate;
  const std::string html = sweep_page(results, {});
  EXPECT_THAT(
      html, AllOf(HasSubstr("± 0.00003</td>"), Not(HasSubstr("± 0.000<")), HasSubstr("<td data-label=\"mean RMSE\">")));
}

// five decimals everywhere, and a table wider than a desk, because runs without a gust differ by rounding
TEST(SweepPage, WhatRoundingLeavesHasNoDigits) {
  Results results = grid();
  for (ResultRow& row : results.rows) row.rmse_z_m = 0.006 + 1e-9 * row.replicate;
  EXPECT_THAT(sweep_page(results, {}), HasSubstr(">0.006 ± 0.000</td>"));
}

TEST(SweepPage, FitsAPhoneAndADesk) { expect_fits(sweep_page(grid(), round_paths())); }

// GIVEN a run that crashed before samples count WHEN the page is written THEN it does not vanish
TEST(SweepPage, SaysHowManyRunsHaveAnError) {
  Results results = grid();
  for (ResultRow& row : results.rows)
    if (row.outcome == Outcome::crashed) row.rmse_xy_m = NAN, row.duration_s = 1.0;
  const std::string html = sweep_page(results, {});
  EXPECT_THAT(html,
              HasSubstr("6 of 240 runs were not completed; they keep their errors up to their end. 6 ended before 2 "
                        "s and have none: means are over the n others."));
  EXPECT_THAT(html, HasSubstr(">4/5, n = 4<"));
  EXPECT_THAT(sweep_page(grid(), {}), Not(HasSubstr("have none")));
}

// the bars of one curve, as "from y to y"
std::vector<std::pair<double, double>> bars_of(const std::string& html) {
  const std::regex bar("whisker\" x1=\"[0-9.]+\" x2=\"[0-9.]+\" y1=\"([0-9.]+)\" y2=\"([0-9.]+)\"");
  std::vector<std::pair<double, double>> found;
  for (std::sregex_iterator at(html.begin(), html.end(), bar), end; at != end; ++at)
    found.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  return found;
}

// one controller on one trajectory over the strength, and runs so far apart at the strongest gust that their interval reaches below 0
Results scattered(double mean_at_2) {
  Results results = grid();
  std::erase_if(results.rows, [](const ResultRow& row) {
    return row.trajectory != "circle" || row.controller != "pid" || row.axes[1].value != "0";
  });
  for (ResultRow& row : results.rows)
    if (row.axes[0].value == "2") row.rmse_xy_m = mean_at_2 * (row.replicate == 1 ? 4.6 : 0.1);
  return results;
}

constexpr double lower_edge_px = 230.0 - 38.0;  // of a chart

// GIVEN an interval that reaches below 0 WHEN the scale is logarithmic THEN its bar goes down to the edge (it was left out)
TEST(SweepPage, ABarThatReachesZeroIsDrawnOnALogScale) {
  const std::string html = sweep_page(scattered(5.0), {});
  expect_sound(html);
  ASSERT_EQ(bars_of(html).size(), 4u);
  EXPECT_EQ(bars_of(html).back().first, lower_edge_px);
  EXPECT_LT(bars_of(html).front().first, lower_edge_px);
  EXPECT_THAT(html, HasSubstr("a bar that reaches 0 ends at the lower edge"));
  EXPECT_THAT(html, Not(HasSubstr("cut off at 0")));
}

// the axis of an error went down to -2.3 m
TEST(SweepPage, AnIntervalEndsAtZero) {
  const std::string html = sweep_page(scattered(0.3), {});
  ASSERT_EQ(bars_of(html).size(), 4u);
  EXPECT_EQ(bars_of(html).back().first, lower_edge_px);
  EXPECT_THAT(html, Not(HasSubstr(">−")));
  EXPECT_THAT(html, HasSubstr("95 % intervals of the mean, cut off at 0 because no error is less."));
  EXPECT_THAT(html, Not(HasSubstr("lower edge")));
  EXPECT_THAT(sweep_page(grid(), {}), Not(AnyOf(HasSubstr("lower edge"), HasSubstr("cut off"))));
}

// GIVEN cells of different numbers of runs WHEN the page is written THEN each caption says its own runs, and who failed
TEST(SweepPage, CaptionsSayHowManyRuns) {
  Results results = grid();
  results.arcs = {{"circle", "15 s, 6.3 m, 1.5 laps"}};
  std::erase_if(results.rows, [](const ResultRow& row) {
    return row.axes[0].value == "0" && row.axes[1].value == "0" && row.replicate > 3;
  });
  const std::string html = sweep_page(results, {});
  EXPECT_THAT(html, HasSubstr("The bar is the mean RMSE. N = 3 to 5 runs for each mean; 6 of 232 were not completed. "
                              "Flown: circle 15 s, 6.3 m, 1.5 laps."));
  EXPECT_THAT(html, HasSubstr("the larger. N = 3 to 5 runs for each mean; 6 of 232 were not completed. Small figures"));
  EXPECT_THAT(html, HasSubstr("N = 3 to 5 runs for each mean; 2 of 72 were not completed. Shown at mass = 0."));
  EXPECT_THAT(html, HasSubstr("N = 5 runs for each mean, all completed. Shown at strength = 1 m/s²."));
  for (ResultRow& row : results.rows)
    if (row.outcome == Outcome::crashed) row.rmse_xy_m = NAN;
  EXPECT_THAT(sweep_page(results, {}),
              HasSubstr("2 of 72 were not completed, and 2 without an error count in no mean. Shown at mass = 0."));
}

}  // namespace sweep_page_test
}  // namespace gustlab
