#include "diagnosis/validation/gust_parts.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "diagnosis/recording/row_intervals.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::surely_a_line, decisions::surely_no_mean;
constexpr double slowest_periods = 2.0;  // in a flight, of the slowest line that is sought
constexpr double fastest_radps = 20.0;
constexpr double bins_apart = 1.5, bins_beside = 8.0;

// Mean square amplitude of the horizontal disturbance at one angular frequency, over flights and axes.
double power(const Session& session, const std::vector<Smoothed>& left, double radps) {
  double sum = 0.0, count = 0.0;
  for (std::size_t f = 0; f < left.size(); ++f) {
    const auto& d = left[f].disturbance;
    for (int axis = 0; axis < 2; ++axis, count += 1.0) {
      double mean = 0.0, a = 0.0, b = 0.0;
      for (const auto& v : d) mean += v[axis] / static_cast<double>(d.size());
      for (std::size_t k = 0; k < d.size(); ++k) {
        const double t = session.flights()[f].samples[k].time_s - session.flights()[f].start_s;
        a += (d[k][axis] - mean) * std::cos(radps * t);
        b += (d[k][axis] - mean) * std::sin(radps * t);
      }
      sum += 4.0 * (a * a + b * b) / std::pow(static_cast<double>(d.size()), 2);
    }
  }
  return sum / std::max(1.0, count);
}

void find_line(const Session& session, const std::vector<Smoothed>& left, GustParts& parts) {
  double duration_s = 1e300;
  for (const FlightData& flight : session.flights()) duration_s = std::min(duration_s, flight.duration_s());
  const double bin = 2.0 * pi / duration_s, step = 0.25 * bin;
  std::vector<double> at, spectrum;
  for (double radps = slowest_periods * bin; radps < fastest_radps; radps += step) {
    at.push_back(radps);
    spectrum.push_back(power(session, left, radps));
  }
  const double axes = 2.0 * static_cast<double>(left.size());
  const double median_of_mean = boost::math::median(boost::math::chi_squared(2.0 * axes)) / (2.0 * axes);
  double least = surely_a_line;
  for (std::size_t i = 1; i + 1 < at.size(); ++i) {
    if (spectrum[i] < spectrum[i - 1] || spectrum[i] < spectrum[i + 1]) continue;
    std::vector<double> beside;
    for (std::size_t j = 0; j < at.size(); ++j) {
      const double bins = std::abs(at[j] - at[i]) / bin;
      if (bins > bins_apart && bins < bins_beside) beside.push_back(spectrum[j]);
    }
    if (beside.size() < 8) continue;
    const double background = median(std::move(beside)) / median_of_mean;
    const double p = boost::math::cdf(
        boost::math::complement(boost::math::chi_squared(2.0 * axes), 2.0 * axes * spectrum[i] / background));
    if (!(p < least)) continue;
    least = p;
    // the top of the parabola through the three
    const double bend = spectrum[i - 1] - 2.0 * spectrum[i] + spectrum[i + 1];
    parts.line_radps = at[i] + (bend < 0.0 ? 0.5 * step * (spectrum[i - 1] - spectrum[i + 1]) / bend : 0.0);
    parts.line_mps2 = std::sqrt(spectrum[i] - background);
    parts.line_deviation_mps2 = std::sqrt(0.5 * background / axes);
    parts.line_deviation_radps = std::sqrt(6.0 * background / axes) / (parts.line_mps2 * duration_s);
  }
}

}  // namespace

GustParts gust_parts(const Session& session, const std::vector<Smoothed>& left) {
  GustParts parts;
  find_line(session, left, parts);
  constexpr std::array<double, 5> lag_s = {0.2, 0.4, 0.6, 0.8, 1.0};
  const auto covariance = [&](double lag, int first, int last) {
    const auto shift = static_cast<std::size_t>(std::lround(lag / session.sample_s()));
    double sum = 0.0, count = 0.0;
    for (const Smoothed& flight : left)
      for (std::size_t k = shift; k < flight.disturbance.size(); ++k)
        for (int axis = first; axis < last; ++axis, count += 1.0)
          sum += flight.disturbance[k][axis] * flight.disturbance[k - shift][axis];
    const double line = 0.5 * parts.line_mps2 * parts.line_mps2 * std::cos(parts.line_radps * lag);
    return sum / std::max(1.0, count) - (last <= 2 ? line : 0.0);
  };
  parts.slow_mps2 = std::sqrt(std::max(0.0, covariance(0.5, 0, 2)));
  // log c = log variance − lag / time, weighed with c
  double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const double lag : lag_s) {
    const double c = covariance(lag, 0, 2);
    if (c <= 0.0) break;
    w += c, x += c * lag, y += c * std::log(c), xx += c * lag * lag, xy += c * lag * std::log(c);
  }
  const double slope = (w * xy - x * y) / (w * xx - x * x);
  if (!(slope < 0.0)) {
    parts.horizontal_mps2 = std::sqrt(session.noise.variance[0]);
    parts.vertical_mps2 = std::sqrt(session.noise.variance[1]);
    parts.time_s = session.noise.time_s[0];
    return parts;
  }
  parts.time_s = -1.0 / slope;
  parts.horizontal_mps2 = std::sqrt(std::exp((y - slope * x) / w));
  parts.vertical_mps2 =
      std::sqrt(std::max(0.0, covariance(lag_s.front(), 2, 3)) * std::exp(lag_s.front() / parts.time_s));
  return parts;
}

std::vector<int> means_of_gust(const Session& session, const Selection& selection, const GustParts& gust) {
  std::vector<int> groups;
  for (const Finding& finding : selection.findings) {
    const Group& group = session.catalogue().groups()[static_cast<std::size_t>(finding.group)];
    if (!group.row->external) continue;
    double chi_squared = 0.0;
    for (const int c : group.columns) {
      const Column& column = session.catalogue().columns()[static_cast<std::size_t>(c)];
      // variance of the mean of an exponentially correlated series
      const double duration_s = session.flights()[static_cast<std::size_t>(column.flight)].duration_s(),
                   x = gust.time_s / duration_s;
      const double sigma_mps2 = column.parameter < 2 ? gust.horizontal_mps2 : gust.vertical_mps2;
      const double variance = 2.0 * sigma_mps2 * sigma_mps2 * x * (1.0 - x * (1.0 - std::exp(-1.0 / x)));
      chi_squared += std::pow(selection.value[c] / session.vehicle().mass_kg, 2) /
                     (variance + std::pow(selection.deviation[c] / session.vehicle().mass_kg, 2));
    }
    const boost::math::chi_squared expected(static_cast<double>(group.columns.size()));
    if (chi_squared < boost::math::quantile(expected, surely_no_mean)) groups.push_back(finding.group);
  }
  return groups;
}

}  // namespace gustlab::diagnosis
