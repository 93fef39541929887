#include "diagnosis/rollout/verify.hpp"

#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/recording/flight_labels.hpp"
#include "diagnosis/rollout/per_flight.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "diagnosis/rollout/rollout.hpp"
#include "gustlab/errors.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double restart_s = 0.5;
constexpr double most_noises = 10.0;  // no quantity counts for more than this many times its noise
constexpr double window_s = 4.0;

// share of the recoverable error (before − noise) that is gone at the horizon of half a second, in units of the noise: what
// is wrong by little says little
double recovered_share(const nlohmann::ordered_json& fit) {
  double closed = 0.0, open = 0.0;
  for (const std::string_view name : fit_quantity_names) {
    const double before = half_a_second_ahead(fit, name, "before"), after = half_a_second_ahead(fit, name, "after"),
                 noise = half_a_second_ahead(fit, name, "noise");
    if (!(before > 1.05 * noise)) continue;
    const double unit = std::max(noise, 1e-9), recoverable = std::min((before - noise) / unit, most_noises);
    closed += recoverable * std::clamp((before - after) / (before - noise), -1.0, 1.0);
    open += recoverable;
  }
  return open > 0.0 ? closed / open : 1.0;
}

// heading, and the tilt of the body's z axis toward x and y of the world
std::array<double, 6> picture(const Vector3& position, const Quaternion& q) {
  const Matrix3 R = q.toRotationMatrix();
  return {position.x(),
          position.y(),
          position.z(),
          std::atan2(R(2, 1), R(2, 2)),
          -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

// the middle of a flight, predicted again and again from recorded states
std::vector<WindowTrace> window_of(const FlightLog& log, const VehicleModel& vehicle,
                                   const std::vector<EffectSpec>& before, const std::vector<EffectSpec>& after,
                                   int jobs) {
  const Recording recording(log, vehicle, ReplayOptions{});
  const RecordedMotion& motion = recording.motion;
  const char* names[] = {"position x", "position y", "position z", "roll", "pitch", "yaw"};
  std::vector<WindowTrace> traces;
  for (int i = 0; i < 6; ++i) traces.push_back({names[i], i < 3 ? "m" : "rad", {}, {}, {}, {}});
  const std::size_t first = motion.nearest(0.5 * motion.time_s(motion.rows() - 1));
  const auto fly = [&](const std::vector<EffectSpec>& effects, std::vector<double> WindowTrace::*into, bool measured) {
    const auto speeds = Rollout(recording, effects).rotor_speeds();
    const PerFlightFit known(recording, effects, speeds, true, jobs);
    Rollout rollout(recording, known.effects(known.known_by(first)));
    double begun_s = -1e9;
    for (std::size_t row = first; row < motion.rows() && motion.time_s(row) < motion.time_s(first) + window_s; ++row) {
      if (!motion.complete(row) || (row > first && !motion.follows(row - 1))) break;
      const bool restart = motion.time_s(row) - begun_s >= restart_s - 1e-9;
      if (restart) {
        rollout.begin(rollout.start(row), speeds);
        begun_s = motion.time_s(row);
      }
      Measured seen;
      const bool finite = rollout.run_to(motion.time_s(row), seen);
      const auto predicted = picture(seen.position_W_m, seen.attitude_WB);
      const auto recorded = picture(motion.position_W_m(row), motion.attitude_WB(row));
      for (std::size_t i = 0; i < 6; ++i) {
        WindowTrace& trace = traces[i];
        (trace.*into).push_back(restart || !finite ? std::nan("") : predicted[i]);
        if (!measured) continue;
        trace.time_s.push_back(recording.log.time_s.front() + motion.time_s(row));
        trace.measured.push_back(recorded[i]);
      }
    }
  };
  fly(before, &WindowTrace::before, true);
  fly(after, &WindowTrace::after, false);
  for (WindowTrace& trace : traces) trace.after.resize(trace.time_s.size(), std::nan(""));
  return traces;
}

}  // namespace

double half_a_second_ahead(const nlohmann::ordered_json& fit, std::string_view quantity, const char* kind) {
  const auto& list = fit.at(std::string(quantity)).at(kind);
  return list.size() > 1 && list[1].is_number() ? list[1].get<double>() : std::nan("");
}

FlightLog with_later_inputs(const FlightLog& log, double by_s) {
  if (by_s == 0.0) return log;
  FlightLog later = log;
  for (std::size_t c = 0; c < log.columns.size(); ++c) {
    if (!is_rotor_column(log.columns[c].name)) continue;
    const auto& from = log.columns[c].values;
    // a column may have empty cells between its samples
    std::vector<std::size_t> rows;
    for (std::size_t k = 0; k < log.rows(); ++k)
      if (std::isfinite(from[k])) rows.push_back(k);
    for (const std::size_t k : rows) {
      const double t = log.time_s[k] - by_s;
      const auto next = std::upper_bound(rows.begin(), rows.end(), t,
                                         [&](double at_s, std::size_t row) { return at_s < log.time_s[row]; });
      if (next == rows.begin() || next == rows.end()) {
        later.columns[c].values[k] = from[next == rows.begin() ? rows.front() : rows.back()];
        continue;
      }
      const std::size_t after = *next, before = *(next - 1);
      const double share = (t - log.time_s[before]) / (log.time_s[after] - log.time_s[before]);
      later.columns[c].values[k] = from[before] + share * (from[after] - from[before]);
    }
  }
  return later;
}

Verification verify(const std::vector<FlightLog>& holdout, const VehicleModel& vehicle,
                    const std::vector<EffectSpec>& found, int jobs) {
  Verification result;
  std::vector<FitErrors> before, after;
  ReplayOptions options;
  options.jobs = jobs;
  const std::vector<EffectSpec> augmented = config::merge_effects(vehicle.effects, found);
  for (const FlightLog& log : holdout) {
    try {
      FitErrors nominal = replay(log, vehicle, vehicle.effects, options);
      after.push_back(replay(log, vehicle, augmented, options));
      before.push_back(std::move(nominal));
      if (result.window.empty()) {
        result.window = window_of(log, vehicle, vehicle.effects, augmented, jobs);
        result.window_file = label_of(log.path);
      }
    } catch (const DataError&) {
      // a log without attitude cannot be flown; what it lacks is said under not_identifiable
    }
  }
  if (before.empty()) return result;
  result.fit = fit_block(before, after);
  result.recovered = recovered_share(result.fit);
  return result;
}

}  // namespace gustlab::diagnosis
