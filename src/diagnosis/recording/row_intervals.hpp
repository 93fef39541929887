// How far apart the rows of a log are, and which of them hold a sample: columns with a rate of their own have empty cells between.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

// what is longer is a gap: of sensors with rows of their own, most intervals are parts of one
inline double longest_interval_s(const std::vector<double>& steps_s) {
  return 1.6 * std::max(median(steps_s), order_statistic(steps_s, 0.75));
}

// from row to row; the mean where rows are not even
inline double interval_s(const std::vector<double>& steps_s) {
  const double even_s = median(steps_s), longest_s = longest_interval_s(steps_s);
  double sum_s = 0.0, count = 0.0;
  for (const double step_s : steps_s)
    if (step_s <= longest_s) sum_s += step_s, count += 1.0;
  return count == 0.0 || std::abs(sum_s / count - even_s) < 0.1 * even_s ? even_s : sum_s / count;
}

// Rows that hold a number.
inline std::vector<std::size_t> sampled_rows(const std::vector<double>& values) {
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < values.size(); ++k)
    if (std::isfinite(values[k])) rows.push_back(k);
  return rows;
}

}  // namespace gustlab::diagnosis
