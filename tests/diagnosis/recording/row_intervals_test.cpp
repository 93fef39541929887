// Intervals of logs that are even, torn, or have rows for several sensors.
#include "diagnosis/recording/row_intervals.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace gustlab::diagnosis {
namespace row_intervals_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Interval, OfEvenRowsIsTheirStepWhateverGapsThereAre) {
  std::vector<double> steps(99, 0.01);
  steps[30] = 2.0;
  EXPECT_EQ(interval_s(steps), 0.01);
  EXPECT_NEAR(longest_interval_s(steps), 0.016, 1e-12);
  EXPECT_EQ(interval_s({}), 0.0);
}

// two sensors in one file: rows at 0, 3, 10, 13, ... ms
TEST(Interval, OfUnevenRowsIsTheirMean) {
  std::vector<double> steps;
  for (int i = 0; i < 50; ++i) steps.push_back(0.003), steps.push_back(0.007);
  EXPECT_NEAR(interval_s(steps), 0.005, 1e-12);
  // neither of the two is a gap, three of them are
  EXPECT_GT(longest_interval_s(steps), 0.007);
  EXPECT_LT(longest_interval_s(steps), 0.021);
  steps.push_back(1.0);
  EXPECT_NEAR(interval_s(steps), 0.005, 1e-12);
}

TEST(SampledRows, AreThoseWithANumber) {
  EXPECT_THAT(sampled_rows({nan, 1.0, 0.0, nan, -2.0}), ElementsAre(1u, 2u, 4u));
  EXPECT_THAT(sampled_rows({nan, std::numeric_limits<double>::infinity()}), IsEmpty());
}

}  // namespace row_intervals_test
}  // namespace gustlab::diagnosis
