// Findings of logs in short: one line per kind, with the flights counted.
#include "diagnosis/result/finding_lines.hpp"

#include <gmock/gmock.h>

namespace gustlab::diagnosis {
namespace finding_lines_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> lines(const std::vector<LogFinding>& findings, std::size_t flights) {
  std::vector<std::string> texts;
  for (const auto& [kind, says] : finding_lines(findings, flights)) texts.push_back(kind + ": " + says);
  return texts;
}

LogFinding finding(const char* file, const char* column, const char* kind, const char* says) {
  return {file, column, kind, 0.0, 1.0, says, false, false};
}

TEST(FindingLines, CountFlightsAndRangeNumbers) {
  EXPECT_THAT(lines({finding("a.csv", "px", "held", "12 % of its samples repeat the one before"),
                     finding("b.csv", "px", "held", "9 % of its samples repeat the one before"),
                     finding("b.csv", "time_s", "gap", "no sample for 0.25 s"),
                     finding("b.csv", "time_s", "gap", "no sample for 1.50 s"),
                     finding("c.csv", "ax…az", "unit", "the accelerometer is in g, not in m/s²: not used"),
                     finding("c.csv", "wx…az", "delay", "the gyro is -20 to 150 ms later"),
                     finding("a.csv", "wx…az", "delay", "the gyro is 5 to 60 ms later")},
                    8),
              ElementsAre("held: 2 of 8 flights: px: 9…12 % of its samples repeat the one before",
                          "gap: b.csv: time_s: no sample for 0.25…1.50 s",
                          "unit: c.csv: ax…az: the accelerometer is in g, not in m/s²: not used",
                          "delay: 2 of 8 flights: wx…az: the gyro is -20…5 to 60…150 ms later"));
}

// flights that were set aside are not counted by the caller
TEST(FindingLines, NeverSayMoreFlightsThanThereAre) {
  EXPECT_THAT(lines({finding("a.csv", "*", "unit", "in g"), finding("b.csv", "*", "unit", "in g")}, 1),
              ElementsAre("unit: 2 of 2 flights: in g"));
}

TEST(FindingLines, OfNothingAreNone) { EXPECT_THAT(lines({}, 3), IsEmpty()); }

}  // namespace finding_lines_test
}  // namespace gustlab::diagnosis
