#include "diagnosis/validation/gust_parts.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "diagnosis/result/decisions.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::surely_a_line, decisions::surely_no_mean;
constexpr double slowest_periods = 2.0;  // in a flight, of the slowest line that is sought
constexpr double fastest_radps = 20.0;
constexpr double bins_apart = 1.5, bins_beside = 8.0;

// Square amplitude of one series at one angular frequency; `value(k)` at sample k of the flight.
template <class Value>
double square_amplitude(const FlightData& flight, double radps, const Value& value) {
  const std::size_t n = flight.samples.size();
  double mean = 0.0, a = 0.0, b = 0.0;
  for (std::size_t k = 0; k < n; ++k) mean += value(k) / static_cast<double>(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double t = flight.samples[k].time_s - flight.start_s;
    a += (value(k) - mean) * std::cos(radps * t);
    b += (value(k) - mean) * std::sin(radps * t);
  }
  return 4.0 * (a * a + b * b) / std::pow(static_cast<double>(n), 2);
}

// Mean square amplitude of a horizontal series at one angular frequency, over flights and axes; `value(f, k, axis)`.
template <class Value>
double power(const Session& session, double radps, const Value& value) {
  double sum = 0.0, count = 0.0;
  for (std::size_t f = 0; f < session.flights().size(); ++f)
    for (int axis = 0; axis < 2; ++axis, count += 1.0)
      sum += square_amplitude(session.flights()[f], radps, [&](std::size_t k) { return value(f, k, axis); });
  return sum / std::max(1.0, count);
}

// Whether a flight repeats a figure, and an angular frequency is one of that figure's harmonics: what the model has wrong of the
// figure's forces has these lines, too.
bool repeats_at(const FlightData& flight, double line_radps) {
  const double bin = 2.0 * pi / flight.flown_s(), count = static_cast<double>(flight.motion.size());
  for (int axis = 0; axis < 3; ++axis) {
    double variance = 0.0, mean = 0.0, most = 0.0, base_radps = 0.0;
    for (const Motion& m : flight.motion) mean += m.velocity_W_mps[axis] / count;
    for (const Motion& m : flight.motion) variance += std::pow(m.velocity_W_mps[axis] - mean, 2) / count;
    if (!(variance > decisions::least_figure_mps * decisions::least_figure_mps)) continue;
    for (double radps = slowest_periods * bin; radps < line_radps + bin; radps += 0.25 * bin) {
      const double square =
          square_amplitude(flight, radps, [&](std::size_t k) { return flight.motion[k].velocity_W_mps[axis]; });
      if (square > most) most = square, base_radps = radps;
    }
    // a sinusoid's variance is half its square amplitude
    if (0.5 * most < decisions::least_share_of_line * variance) continue;
    const double times = std::round(line_radps / base_radps);
    if (times >= 1.0 && times <= decisions::most_harmonics && std::abs(line_radps - times * base_radps) < 0.5 * bin)
      return true;
  }
  return false;
}

bool comes_with_motion(const Session& session, const GustParts& parts) {
  // a gust moves the vehicle by no more than itself, whatever a controller does about it; of a motion of its own a model misses
  // a part. Without a pose nobody knows
  const double moves_mps2 = std::sqrt(power(session, parts.line_radps, [&](std::size_t f, std::size_t k, int axis) {
    return session.flights()[f].motion[k].acceleration_W_mps2[axis];
  }));
  if (moves_mps2 == 0.0 || parts.line_mps2 < decisions::least_share_of_motion * moves_mps2) return true;
  const auto repeating = std::count_if(session.flights().begin(), session.flights().end(),
                                       [&](const FlightData& f) { return repeats_at(f, parts.line_radps); });
  return 2 * repeating > std::ssize(session.flights());
}

void find_line(const Session& session, const std::vector<Smoothed>& left, GustParts& parts) {
  double duration_s = 1e300;
  for (const FlightData& flight : session.flights()) duration_s = std::min(duration_s, flight.flown_s());
  const double bin = 2.0 * pi / duration_s, step = 0.25 * bin;
  std::vector<double> at, spectrum;
  for (double radps = slowest_periods * bin; radps < fastest_radps; radps += step) {
    at.push_back(radps);
    spectrum.push_back(
        power(session, radps, [&](std::size_t f, std::size_t k, int axis) { return left[f].disturbance[k][axis]; }));
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
    if (!(background > 0.0)) continue;  // nothing pushes to the side at all
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
  parts.line_of_motion = parts.line_mps2 > 0.0 && comes_with_motion(session, parts);
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
    const Group& group = session.catalogue().group(finding.group);
    if (!group.row->external) continue;
    double chi_squared = 0.0;
    for (const int c : group.columns) {
      const Column& column = session.catalogue().column(c);
      // variance of the mean of an exponentially correlated series
      const double duration_s = session.flights()[static_cast<std::size_t>(column.flight)].flown_s(),
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
