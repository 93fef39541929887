// Order statistics of a sample, and correlation: the one place for medians, quantiles and ranks.
#pragma once

#include <cstddef>
#include <vector>

namespace gustlab {

// The q-quantile of values by linear interpolation between order statistics, numpy's default. NaN of none. q in [0, 1].
double quantile(std::vector<double> values, double q);
// The value below which about this share (0 to 1) of the values lies: always one of them, so that a step of a log is a step that it has. 0 of none.
double order_statistic(std::vector<double> values, double share);
// One of the values: the upper of the two in the middle where their number is even. 0 of none.
double median(std::vector<double> values);

// Indices of values, those of the least first; equal values stay in their order.
std::vector<std::size_t> ascending(const std::vector<double>& values);
// Rank of each value, from 0; equal values have ranks in their order.
std::vector<double> ranks(const std::vector<double>& values);
// Pearson's correlation, -1 to 1; of ranks it is Spearman's. 0 where one of them is constant. Precondition: equal lengths.
double correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace gustlab
