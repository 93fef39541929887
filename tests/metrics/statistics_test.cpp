#include "metrics/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace gustlab {
namespace statistics_test {

const std::vector<double> a{5.1, 4.9, 6.2, 5.7, 5.5}, b{4.4, 4.6, 5.9, 5.0, 5.2};

TEST(Statistics, SummaryUsesTheSampleDeviation) {
  const Summary summary = summarize(a);
  EXPECT_EQ(summary.n, 5u);
  EXPECT_DOUBLE_EQ(summary.mean, 5.48);
  EXPECT_NEAR(summary.sd, 0.5118593557, 1e-9);
  EXPECT_DOUBLE_EQ(summary.median, 5.5);
}

TEST(Statistics, ValuesThatAreNotANumberDoNotCount) {
  const std::vector<double> values{1.0, std::numeric_limits<double>::quiet_NaN(), 3.0};
  EXPECT_EQ(summarize(values).n, 2u);
  EXPECT_DOUBLE_EQ(summarize(values).mean, 2.0);
  EXPECT_TRUE(std::isnan(summarize(std::vector<double>{1.0}).sd));
}

// scipy.stats.ttest_ind(a, b, equal_var=False)
TEST(Statistics, WelchAgreesWithScipy) {
  const TTest test = welch_test(summarize(a), summarize(b));
  EXPECT_NEAR(test.difference, 0.46, 1e-12);
  EXPECT_NEAR(test.t, 1.3235012765914025, 1e-9);
  EXPECT_NEAR(test.dof, 7.862074910564198, 1e-9);
  EXPECT_NEAR(test.p_value, 0.22285812387958825, 1e-9);
}

// scipy.stats.ttest_rel(a, b)
TEST(Statistics, PairedAgreesWithScipy) {
  const TTest test = paired_test(a, b);
  EXPECT_NEAR(test.t, 4.6948553403344295, 1e-9);
  EXPECT_DOUBLE_EQ(test.dof, 4.0);
  EXPECT_NEAR(test.p_value, 0.009343999999999969, 1e-9);
}

TEST(Statistics, EqualSamplesAreNoDifferenceAndAConstantOneIsCertain) {
  EXPECT_DOUBLE_EQ(paired_test(a, a).p_value, 1.0);
  const std::vector<double> zeros(5, 0.0), ones(5, 1.0);
  EXPECT_DOUBLE_EQ(paired_test(ones, zeros).p_value, 0.0);
  EXPECT_DOUBLE_EQ(welch_test(summarize(ones), summarize(zeros)).p_value, 0.0);
  EXPECT_TRUE(std::isnan(paired_test(std::vector<double>{1.0}, std::vector<double>{0.0}).p_value));
}

// statsmodels multipletests([0.01, 0.04, 0.03, 0.005], method="holm")
TEST(Statistics, HolmAgreesWithStatsmodels) {
  const std::vector<double> adjusted = holm(std::vector{0.01, 0.04, 0.03, 0.005, std::nan("")});
  for (const auto& [is, wanted] :
       {std::pair{adjusted[0], 0.03}, {adjusted[1], 0.06}, {adjusted[2], 0.06}, {adjusted[3], 0.02}})
    EXPECT_NEAR(is, wanted, 1e-12);
  EXPECT_TRUE(std::isnan(adjusted[4]));
}

// scipy.stats.t.interval(0.9, 2, loc=0.2, scale=0.1 / sqrt(3))
TEST(Statistics, PairedIntervalIsStudents) {
  const Interval interval = paired_interval(std::vector{1.1, 2.2, 3.3}, std::vector{1.0, 2.0, 3.0}, 0.90);
  EXPECT_NEAR(interval.low, 0.2 - 2.919985580 * 0.1 / std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(interval.high, 0.2 + 2.919985580 * 0.1 / std::sqrt(3.0), 1e-9);
}

// statsmodels proportion_confint(8, 10, method="wilson")
TEST(Statistics, WilsonAgreesWithThePublishedFormula) {
  const Interval interval = wilson_interval(8, 10);
  EXPECT_NEAR(interval.low, 0.4901625, 1e-6);
  EXPECT_NEAR(interval.high, 0.9433178, 1e-6);
  EXPECT_DOUBLE_EQ(wilson_interval(0, 0).high, 1.0);
  EXPECT_DOUBLE_EQ(wilson_interval(0, 10).low, 0.0);
  EXPECT_DOUBLE_EQ(wilson_interval(10, 10).high, 1.0);
}

TEST(Statistics, BootstrapIsAFunctionOfItsInputAndCoversTheMean) {
  const RandomStream stream(7, 1, "bootstrap");
  const Interval once = paired_bootstrap(a, b, stream), again = paired_bootstrap(a, b, stream);
  EXPECT_EQ(once.low, again.low);
  EXPECT_EQ(once.high, again.high);
  EXPECT_LT(once.low, 0.46);
  EXPECT_GT(once.high, 0.46);
  // the percentile interval of five differences lies near mean ± 1.96 sd sqrt(4/5) / sqrt(5)
  EXPECT_NEAR(once.high - once.low, 2 * 1.96 * 0.219089 * std::sqrt(0.8 / 5.0), 0.03);
}

}  // namespace statistics_test
}  // namespace gustlab
