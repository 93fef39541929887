// Statistics of runs: moments, t-tests, proportions, and a bootstrap of paired differences.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gustlab/random.hpp"

namespace gustlab {

// NaN where undefined: mean and median of nothing, sd of fewer than two.
struct Summary {
  std::size_t n = 0;
  double mean;
  double sd;  // of the sample, ddof 1
  double median;
};
// Values that are NaN do not count.
Summary summarize(std::span<const double> values);

struct Interval {
  double low, high;
};

// Of the hypothesis that a mean difference is zero. Two-sided; p is NaN when there are too few values.
struct TTest {
  double difference;  // mean a − mean b
  double t;
  double dof;
  double p_value;
};
// From a difference and its standard error; undefined where one of them is.
TTest t_test(double difference, double standard_error, double dof);
// Unequal variances (Welch, Biometrika 34, 1947), from moments, so that published ones can be used.
TTest welch_test(const Summary& a, const Summary& b);
// a[i] and b[i] met the same gust. Pairs with a NaN do not count. Precondition: equal lengths.
TTest paired_test(std::span<const double> a, std::span<const double> b);
// Student's interval of a mean; NaN when there are fewer than two values.
Interval mean_interval(const Summary& summary, double confidence);
// Student's interval of the mean of a[i] − b[i]; NaN when there are fewer than two pairs.
Interval paired_interval(std::span<const double> a, std::span<const double> b, double confidence);
// p-values as they count where many tests are made at once (Holm, Scand. J. Stat. 6, 1979). NaN stays, and is no test.
std::vector<double> holm(std::span<const double> p_values);

// Of a proportion (Wilson, JASA 22, 1927). [0, 1] when there was no trial.
Interval wilson_interval(std::size_t successes, std::size_t trials, double confidence = 0.95);

// Percentile bootstrap of the mean of a[i] − b[i]. The stream decides the resamples, so the same input gives the same
// interval. NaN when there is no pair. Precondition: equal lengths.
Interval paired_bootstrap(std::span<const double> a, std::span<const double> b, const RandomStream& stream,
                          double confidence = 0.95, std::size_t resamples = 10000);

}  // namespace gustlab
