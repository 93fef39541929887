// Medians, quantiles, ranks and correlations of samples that are small enough to work out by hand.
#include "util/quantiles.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace gustlab {
namespace quantiles_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Quantile, EndsAreExactAndTheMiddleIsLinear) {
  const std::vector<double> values{4.0, 1.0, 3.0, 2.0};
  EXPECT_DOUBLE_EQ(quantile(values, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(quantile(values, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(quantile(values, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile(values, 0.25), 1.75);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(OrderStatistic, IsAValueOfTheSample) {
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(median({4.0}), 4.0);
  EXPECT_EQ(median({9.0, 1.0, 5.0}), 5.0);
  EXPECT_EQ(median({1.0, 2.0}), 2.0);
  EXPECT_EQ(order_statistic({4.0, 3.0, 2.0, 1.0}, 0.75), 4.0);
  EXPECT_EQ(order_statistic({4.0, 3.0, 2.0, 1.0}, 0.0), 1.0);
  EXPECT_EQ(order_statistic({4.0, 3.0, 2.0, 1.0}, 1.0), 4.0);
}

TEST(Ranks, OfEqualValuesAreInTheirOrder) {
  EXPECT_THAT(ascending({3.0, 1.0, 3.0, 0.0}), ElementsAre(3u, 1u, 0u, 2u));
  EXPECT_THAT(ranks({3.0, 1.0, 3.0, 0.0}), ElementsAre(2.0, 1.0, 3.0, 0.0));
  EXPECT_THAT(ascending({}), IsEmpty());
}

TEST(Correlation, OfALineIsOneAndOfAConstantNothing) {
  EXPECT_DOUBLE_EQ(correlation({1.0, 2.0, 4.0}, {3.0, 5.0, 9.0}), 1.0);
  EXPECT_DOUBLE_EQ(correlation({1.0, 2.0, 4.0}, {-1.0, -2.0, -4.0}), -1.0);
  EXPECT_EQ(correlation({1.0, 2.0, 4.0}, {7.0, 7.0, 7.0}), 0.0);
  // x and x² about zero
  EXPECT_NEAR(correlation({-1.0, 0.0, 1.0}, {1.0, 0.0, 1.0}), 0.0, 1e-15);
  // a curve that only rises: all of its ranks agree
  EXPECT_LT(correlation({1.0, 2.0, 3.0}, {1.0, 10.0, 1000.0}), 0.9);
  EXPECT_DOUBLE_EQ(correlation(ranks({1.0, 2.0, 3.0}), ranks({1.0, 10.0, 1000.0})), 1.0);
}

}  // namespace quantiles_test
}  // namespace gustlab
