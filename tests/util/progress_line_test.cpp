// What the line of long work says, and when; the test brings the time.
#include "util/progress_line.hpp"

#include <gmock/gmock.h>

namespace gustlab {
namespace progress_line_test {

using ::testing::ElementsAre;
using ::testing::Optional;

// seconds at which something is printed, asked every half second
std::vector<double> printed(ProgressLine line, double until_s) {
  std::vector<double> at_s;
  line.report("choosing effects", {}, 0.0);
  for (double now_s = 0.0; now_s <= until_s; now_s += 0.5)
    if (line.due(now_s)) at_s.push_back(now_s);
  return at_s;
}

TEST(ProgressLine, IsRefreshedByTimeAndNotByReports) {
  EXPECT_THAT(printed(ProgressLine(true), 3.5), ElementsAre(2.0, 2.5, 3.0, 3.5));
  EXPECT_THAT(printed(ProgressLine(false), 100.0), ElementsAre(30.0, 60.0, 90.0));
}

TEST(ProgressLine, SaysNothingBeforeTheFirstReport) { EXPECT_FALSE(ProgressLine(true).due(100.0)); }

// the shares of a diagnosis were guesses, and the time that was said to be left wrong by a factor of 20
TEST(ProgressLine, PromisesNoTimeLeftWhereNoShareIsKnown) {
  ProgressLine line(true);
  line.report("reading the flights", {}, 0.0);
  line.report("choosing effects", {}, 10.0);
  EXPECT_THAT(line.due(25.2), Optional(std::string("choosing effects, 25 s so far")));
  EXPECT_THAT(line.due(85.0), Optional(std::string("choosing effects, 1 min 25 s so far")));
}

TEST(ProgressLine, CountsDownFromTheLastReport) {
  ProgressLine line(true);
  line.report("0/4 runs", 0.0, 0.0);
  EXPECT_EQ(line.text(5.0), "0/4 runs, 5 s so far");
  line.report("1/4 runs", 0.25, 10.0);
  EXPECT_EQ(line.text(10.0), "1/4 runs, 30 s left");
  EXPECT_EQ(line.text(18.0), "1/4 runs, 22 s left");
  // another stage of the same run
  line.report("25 %, b: testing", 0.25, 20.0);
  EXPECT_EQ(line.text(20.0), "25 %, b: testing, 20 s left");
  // later than it was told: nothing is promised any more
  EXPECT_EQ(line.text(50.0), "25 %, b: testing, 50 s so far");
}

TEST(ProgressLine, WhatWasThroughAtTheStartTellsNoTime) {
  ProgressLine line(true);
  line.report("2/4 runs", 0.5, 0.0);
  line.report("3/4 runs", 0.75, 10.0);
  EXPECT_EQ(line.text(10.0), "3/4 runs, 10 s left");
}

}  // namespace progress_line_test
}  // namespace gustlab
