#include "metrics/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

#include "util/quantiles.hpp"

namespace gustlab {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> finite_differences(std::span<const double> a, std::span<const double> b) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!std::isnan(a[i] - b[i])) differences.push_back(a[i] - b[i]);
  return differences;
}

}  // namespace

Summary summarize(std::span<const double> values) {
  std::vector<double> known;
  for (const double value : values)
    if (!std::isnan(value)) known.push_back(value);
  Summary summary{known.size(), nan, nan, nan};
  if (known.empty()) return summary;

  const auto n = static_cast<double>(known.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : known) sum += value;
  summary.mean = sum / n;
  for (const double value : known) squares += (value - summary.mean) * (value - summary.mean);
  if (known.size() > 1) summary.sd = std::sqrt(squares / (n - 1.0));
  summary.median = quantile(std::move(known), 0.5);
  return summary;
}

TTest t_test(double difference, double standard_error, double dof) {
  TTest test{difference, nan, dof, nan};
  if (!(dof > 0.0) || std::isnan(difference) || std::isnan(standard_error)) return test;
  if (standard_error == 0.0) {
    test.t = difference == 0.0 ? 0.0 : std::copysign(std::numeric_limits<double>::infinity(), difference);
    test.p_value = difference == 0.0 ? 1.0 : 0.0;
    return test;
  }
  test.t = difference / standard_error;
  const boost::math::students_t distribution(dof);
  test.p_value = 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(test.t)));
  return test;
}

// dof: Welch–Satterthwaite
TTest welch_test(const Summary& a, const Summary& b) {
  const double difference = a.mean - b.mean;
  if (a.n < 2 || b.n < 2) return {difference, nan, nan, nan};
  const auto na = static_cast<double>(a.n), nb = static_cast<double>(b.n);
  const double va = a.sd * a.sd / na, vb = b.sd * b.sd / nb;
  if (va + vb == 0.0) return t_test(difference, 0.0, na + nb - 2.0);
  const double dof = (va + vb) * (va + vb) / (va * va / (na - 1.0) + vb * vb / (nb - 1.0));
  return t_test(difference, std::sqrt(va + vb), dof);
}

TTest paired_test(std::span<const double> a, std::span<const double> b) {
  const Summary summary = summarize(finite_differences(a, b));
  if (summary.n < 2) return {summary.mean, nan, nan, nan};
  const auto n = static_cast<double>(summary.n);
  return t_test(summary.mean, summary.sd / std::sqrt(n), n - 1.0);
}

Interval mean_interval(const Summary& summary, double confidence) {
  if (summary.n < 2) return {nan, nan};
  const auto n = static_cast<double>(summary.n);
  const double half =
      boost::math::quantile(boost::math::students_t(n - 1.0), 0.5 + 0.5 * confidence) * summary.sd / std::sqrt(n);
  return {summary.mean - half, summary.mean + half};
}

Interval paired_interval(std::span<const double> a, std::span<const double> b, double confidence) {
  const Summary summary = summarize(finite_differences(a, b));
  return mean_interval(summary, confidence);
}

std::vector<double> holm(std::span<const double> p_values) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p_values.size(); ++i)
    if (!std::isnan(p_values[i])) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size(), nan);
  double most = 0.0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    most = std::max(most, std::min(1.0, static_cast<double>(order.size() - rank) * p_values[order[rank]]));
    adjusted[order[rank]] = most;
  }
  return adjusted;
}

Interval wilson_interval(std::size_t successes, std::size_t trials, double confidence) {
  if (trials == 0) return {0.0, 1.0};
  const double z = boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * confidence);
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
  const double half = z / (1.0 + z * z / n) * std::sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

Interval paired_bootstrap(std::span<const double> a, std::span<const double> b, const RandomStream& stream,
                          double confidence, std::size_t resamples) {
  const std::vector<double> differences = finite_differences(a, b);
  if (differences.empty()) return {nan, nan};
  const auto n = static_cast<double>(differences.size());
  std::vector<double> means(resamples);
  for (std::size_t r = 0; r < resamples; ++r) {
    double sum = 0.0;
    for (std::size_t i = 0; i < differences.size(); ++i) {
      const double uniform = stream.uniform4(i / 4, static_cast<std::uint32_t>(r))[i % 4];
      sum += differences[static_cast<std::size_t>(uniform * n)];
    }
    means[r] = sum / n;
  }
  const double tail = 0.5 * (1.0 - confidence);
  return {quantile(means, tail), quantile(means, 1.0 - tail)};
}

}  // namespace gustlab
