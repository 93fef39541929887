#include "diagnosis/recording/clock_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/recording/row_intervals.hpp"
#include "diagnosis/recording/vehicle_check.hpp"

namespace gustlab::diagnosis {

namespace {

using Pair = Eigen::Vector2d;  // roll and pitch

constexpr double stretch_s = 1.25, stretches_per_verdict = 2.0;
constexpr double most_offset_s = 0.2;
constexpr double least_jump_s = 0.03;    // a motor lag, seen at other frequencies, varies less
constexpr double least_jump_gain = 9.0;  // twice the log likelihood per stretch, three standard deviations each
constexpr double memory_s = 0.1;         // over which the error of a rate from smoothed attitudes is correlated
constexpr double wander_sd_s = 0.01, cost_of_jump = 8.0;  // from stretch to stretch; of the log likelihood
constexpr double cost_of_slope = 2.0;  // more than so many standard deviations apart is a jump, not a slope

// what is compared: how well two streams agree, and how much angular motion there must be
struct Demand {
  double agreement, variance;
};
constexpr Demand of_gyro = {0.8, 0.05};     // (rad/s)², roll and pitch together: less has no time
constexpr Demand of_commands = {0.5, 1.0};  // (rad/s²)²

// Log likelihood of every lag of `late` behind `early`, per stretch of the flight that shows one; lags are in samples, −most to most.
struct Likelihood {
  std::int64_t most = 0;
  double sample_s = 0.0;
  std::vector<double> middle_s;
  std::vector<std::vector<double>> over_lags;
  std::vector<bool> observable;
};

Likelihood likelihood_of(const FlightData& flight, const std::vector<Pair>& early, const std::vector<Pair>& late,
                         const Demand& demand, double length_s) {
  Likelihood result;
  result.sample_s = flight.sample_s;
  result.most = static_cast<std::int64_t>(std::lround(most_offset_s / flight.sample_s));
  const auto size = static_cast<std::int64_t>(late.size());
  for (std::size_t first = 0, last = 0; first < early.size(); first = last) {
    const double from_s = flight.samples[first].time_s;
    while (last < early.size() && flight.samples[last].time_s < from_s + length_s) ++last;
    const double independent = 2.0 * static_cast<double>(last - first) * flight.sample_s / memory_s;
    double best = -1.0, energy = 0.0;
    std::vector<double> over_lags;
    for (std::int64_t lag = -result.most; lag <= result.most; ++lag) {
      double xy = 0.0, xx = 0.0, yy = 0.0;
      for (std::size_t k = first; k < last; ++k) {
        const std::int64_t j = static_cast<std::int64_t>(k) + lag;
        if (j < 0 || j >= size || !late[static_cast<std::size_t>(j)].allFinite() || !early[k].allFinite()) continue;
        xy += late[static_cast<std::size_t>(j)].dot(early[k]);
        xx += late[static_cast<std::size_t>(j)].squaredNorm();
        yy += early[k].squaredNorm();
      }
      const double r = xy / std::sqrt(xx * yy + 1e-300);
      over_lags.push_back(-0.5 * independent * std::log(1.0 - std::min(r * std::abs(r), 0.9999)));
      if (r > best) best = r, energy = yy / static_cast<double>(last - first);
    }
    result.middle_s.push_back(0.5 * (from_s + flight.samples[last - 1].time_s));
    result.over_lags.push_back(std::move(over_lags));
    result.observable.push_back(best >= demand.agreement && energy >= demand.variance);
  }
  return result;
}

// Is one lag for the whole flight clearly worse than one for each stretch, and are those far apart?
bool changes(const Likelihood& of) {
  std::vector<double> lags_s;
  std::vector<double> sum(of.over_lags.empty() ? 0 : of.over_lags.front().size(), 0.0);
  double each = 0.0;
  for (std::size_t s = 0; s < of.over_lags.size(); ++s) {
    if (!of.observable[s]) continue;
    const auto& lags = of.over_lags[s];
    const auto best = std::max_element(lags.begin(), lags.end());
    lags_s.push_back(static_cast<double>(best - lags.begin()) * of.sample_s);
    each += *best;
    for (std::size_t l = 0; l < lags.size(); ++l) sum[l] += lags[l];
  }
  std::sort(lags_s.begin(), lags_s.end());
  const auto count = static_cast<double>(lags_s.size());
  // of many the outermost two may be errors
  if (lags_s.size() >= 6) lags_s = {lags_s.begin() + 1, lags_s.end() - 1};
  if (lags_s.size() < 2 || lags_s.back() - lags_s.front() <= std::max(least_jump_s, 3.1 * of.sample_s)) return false;
  // slow angular motion has a flat top: what one delay for the whole flight explains as well is no jump
  return 2.0 * (each - *std::max_element(sum.begin(), sum.end())) >= least_jump_gain * count;
}

// The likeliest course of a lag that wanders a little from stretch to stretch and jumps now and then (Viterbi, IEEE Trans. Inf.
// Theory 13, 1967). A stretch that shows none follows its neighbours.
ClockTrack likeliest_track(const Likelihood& of) {
  const std::size_t lags = of.over_lags.front().size(), count = of.over_lags.size();
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(4.0 * wander_sd_s / of.sample_s));
  std::vector<double> value(lags, 0.0);
  std::vector<std::vector<std::size_t>> came(count, std::vector<std::size_t>(lags, 0));
  for (std::size_t s = 0; s < count; ++s) {
    const std::vector<double> before = value;
    const auto jump = static_cast<std::size_t>(std::max_element(before.begin(), before.end()) - before.begin());
    for (std::size_t l = 0; l < lags; ++l) {
      double best = before[jump] - cost_of_jump;
      came[s][l] = jump;
      for (std::ptrdiff_t d = -reach; d <= reach; ++d) {
        const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(l) + d;
        if (from < 0 || from >= static_cast<std::ptrdiff_t>(lags)) continue;
        const double way = before[static_cast<std::size_t>(from)] -
                           0.5 * std::pow(static_cast<double>(d) * of.sample_s / wander_sd_s, 2);
        if (way > best) best = way, came[s][l] = static_cast<std::size_t>(from);
      }
      value[l] = best + (of.observable[s] ? of.over_lags[s][l] : 0.0);
    }
  }
  ClockTrack track{of.middle_s, std::vector<double>(count)};
  auto at = static_cast<std::size_t>(std::max_element(value.begin(), value.end()) - value.begin());
  for (std::size_t s = count; s-- > 0; at = came[s][at]) {
    double lag = static_cast<double>(static_cast<std::int64_t>(at) - of.most);
    // the top of a parabola through three points
    if (of.observable[s] && at > 0 && at + 1 < lags) {
      const auto& l = of.over_lags[s];
      const double bend = l[at - 1] - 2.0 * l[at] + l[at + 1];
      if (bend < 0.0) lag += std::clamp(0.5 * (l[at - 1] - l[at + 1]) / bend, -0.5, 0.5);
    }
    track.latency_s[s] = lag * of.sample_s;
  }
  return track;
}

std::optional<ClockTrack> track_of(const FlightData& flight, const std::vector<Pair>& early,
                                   const std::vector<Pair>& late, const Demand& demand) {
  if (!changes(likelihood_of(flight, early, late, demand, stretches_per_verdict * stretch_s))) return std::nullopt;
  return likeliest_track(likelihood_of(flight, early, late, demand, stretch_s));
}

// value of a column between the rows that have one; NaN outside
double between(const std::vector<double>& time_s, const std::vector<double>& values,
               const std::vector<std::size_t>& rows, double at_s, bool held) {
  const auto next =
      std::upper_bound(rows.begin(), rows.end(), at_s, [&](double t, std::size_t row) { return t < time_s[row]; });
  if (next == rows.begin() || next == rows.end()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t a = *(next - 1), b = *next;
  const double part = held ? 0.0 : (at_s - time_s[a]) / (time_s[b] - time_s[a]);
  return values[a] + part * (values[b] - values[a]);
}

}  // namespace

double ClockTrack::at(double at_s) const {
  const auto next = static_cast<std::size_t>(std::upper_bound(time_s.begin(), time_s.end(), at_s) - time_s.begin());
  if (next == 0) return latency_s.front();
  if (next == time_s.size()) return latency_s.back();
  const double before = latency_s[next - 1], after = latency_s[next],
               part = (at_s - time_s[next - 1]) / (time_s[next] - time_s[next - 1]);
  if (std::abs(after - before) > cost_of_slope * wander_sd_s) return part < 0.5 ? before : after;
  return before + part * (after - before);
}

double ClockTrack::least_s() const { return *std::min_element(latency_s.begin(), latency_s.end()); }
double ClockTrack::most_s() const { return *std::max_element(latency_s.begin(), latency_s.end()); }

std::optional<ClockTrack> gyro_track(const FlightData& pose, const std::vector<Vector3>& rate_B_radps) {
  std::vector<Pair> early, late;
  for (const Motion& motion : pose.motion) early.emplace_back(motion.body_rate_B_radps.head<2>());
  for (const Vector3& rate : rate_B_radps) late.emplace_back(rate.head<2>());
  return track_of(pose, early, late, of_gyro);
}

std::optional<ClockTrack> command_track(const FlightData& flight, const VehicleModel& vehicle) {
  if (flight.collective_only || flight.samples.size() < 200) return std::nullopt;
  const AngularAccelerationSeries series = angular_acceleration_series(flight, vehicle);
  return track_of(flight, series.torque, series.acceleration, of_commands);
}

FlightLog laid_on_pose_clock(FlightLog log, const ClockTrack& track) {
  constexpr std::string_view on_board[] = {"wx", "wy", "wz", "ax", "ay", "az", "vbat"};
  for (LogColumn& column : log.columns) {
    const bool input = is_rotor_column(column.name);
    if (!input && std::find(std::begin(on_board), std::end(on_board), column.name) == std::end(on_board)) continue;
    const bool held = column.name.starts_with('u') && log.meta.hold == Hold::zoh;
    const std::vector<double> values = column.values;
    const std::vector<std::size_t> rows = sampled_rows(values);
    for (const std::size_t k : rows)
      column.values[k] = between(log.time_s, values, rows, log.time_s[k] + track.at(log.time_s[k]), held);
  }
  return log;
}

bool clocks_apart(const std::vector<FlightData>& flights, const VehicleModel& vehicle,
                  const std::vector<LogFinding>& of_logs, std::vector<LogFinding>& findings) {
  bool apart = false;
  for (const FlightData& flight : flights) {
    const auto finding = std::find_if(of_logs.begin(), of_logs.end(),
                                      [&](const LogFinding& f) { return f.kind == "delay" && f.file == flight.label; });
    if (finding == of_logs.end()) continue;
    const std::optional<ClockTrack> track = command_track(flight, vehicle);
    apart = apart || finding->sets_column_aside;
    if (!track) continue;
    apart = true;
    findings.push_back(
        {flight.label, "u1…uN", "delay", flight.start_s, flight.start_s + flight.duration_s(),
         fmt::format("the vehicle turns {:.0f} to {:.0f} ms after its rotors are told to, another time "
                     "in each stretch of the flight: "
                     "inputs and motion are on two clocks, and torques from sample to sample are not judged",
                     1e3 * track->least_s(), 1e3 * track->most_s()),
         false, false});
  }
  return apart;
}

}  // namespace gustlab::diagnosis
