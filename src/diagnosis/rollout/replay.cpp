#include "diagnosis/rollout/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "diagnosis/rollout/per_flight.hpp"
#include "diagnosis/rollout/rollout.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/random.hpp"
#include "util/parallel.hpp"
#include "util/rotations.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t windows_per_task = 32;

using Errors = std::array<double, 4>;

// distance of two samples in each quantity
Errors distance(const Measured& a, const Measured& b) {
  return {(a.position_W_m - b.position_W_m).norm(), (a.velocity_W_mps - b.velocity_W_mps).norm(),
          turn_between(a.attitude_WB, b.attitude_WB).norm(), (a.body_rate_B_radps - b.body_rate_B_radps).norm()};
}

Measured recorded(const RecordedMotion& motion, std::size_t row) {
  return {motion.position_W_m(row), motion.velocity_W_mps(row), motion.attitude_WB(row), motion.body_rate_B_radps(row),
          Vector3::Zero()};
}

struct Window {
  std::size_t row;
  std::vector<std::size_t> targets;  // one per horizon
};

// every start from which all horizons lie in one unbroken stretch
std::vector<Window> find_windows(const RecordedMotion& motion, const ReplayOptions& options, double pose_delay_s) {
  std::vector<Window> windows;
  for (std::size_t row = 0; row < motion.rows();) {
    Window window{row, {}};
    const double t = motion.time_s(row);
    bool good = motion.can_start(row) && motion.time_s(motion.stretch(row)) <= t - pose_delay_s + 1e-9;
    for (const double horizon : options.horizon_s) {
      const std::size_t target = motion.nearest(t + horizon);
      good = good && target > row && motion.stretch(target) == motion.stretch(row) && motion.complete(target) &&
             std::abs(motion.time_s(target) - t - horizon) <= 0.75 * motion.sample_s();
      window.targets.push_back(target);
    }
    const std::size_t stride = options.stride > 0 ? static_cast<std::size_t>(options.stride)
                               : good             ? window.targets.back() - row
                                                  : 1;
    if (good) windows.push_back(std::move(window));
    row += stride;
  }
  return windows;
}

// a sample with white noise; numbered by row and by what it is drawn for
Measured noisy(const Measured& exact, const std::array<double, 4>& deviation, std::size_t row, std::uint32_t lane) {
  const RandomStream stream(1, 0, "replay_noise");
  std::array<double, 12> n;
  for (std::uint32_t part = 0; part < 3; ++part) {
    const auto four = stream.normal4(row, 3 * lane + part);
    std::copy(four.begin(), four.end(), n.begin() + 4 * part);
  }
  const auto draw = [&](std::size_t quantity) {
    return Vector3(deviation[quantity] * Vector3(n.data() + 3 * quantity));
  };
  Measured result = exact;
  result.position_W_m += draw(0);
  result.velocity_W_mps += draw(1);
  result.attitude_WB = turned(exact.attitude_WB, draw(2));
  result.body_rate_B_radps += draw(3);
  return result;
}

class Replayer {
 public:
  Replayer(const Recording& recording, const ReplayOptions& options, const std::vector<Window>& windows,
           FitErrors& errors)
      : recording_(recording), options_(options), windows_(windows), errors_(errors) {}

  void replay(Rollout& rollout, const std::vector<RotorArray>& rotor_speeds, std::size_t index) {
    const RecordedMotion& motion = recording_.motion;
    const Window& window = windows_[index];
    VehicleState start = rollout.start(window.row);
    if (options_.correct_start) options_.correct_start(window.row, start);
    std::vector<Measured> predicted(window.targets.size());
    bool finite = true;
    rollout.begin(start, rotor_speeds);
    for (std::size_t h = 0; h < window.targets.size(); ++h) {
      const std::size_t target = window.targets[h];
      finite = finite && rollout.run_to(motion.time_s(target), predicted[h]);
      const Measured truth = recorded(motion, target);
      write(&FitErrors::Quantity::hold, index, h, distance(recorded(motion, window.row), truth));
      write(&FitErrors::Quantity::model, index, h, finite ? distance(predicted[h], truth) : Errors{nan, nan, nan, nan});
    }
    if (!options_.with_noise) return;

    // the same rollout from a start as wrong as the sensors are, seen with their noise
    const Measured shaken =
        noisy({start.position_W_m, start.velocity_W_mps, start.attitude_WB, start.body_rate_B_radps, {}},
              motion.noise(), window.row, 0);
    start.position_W_m = shaken.position_W_m;
    start.velocity_W_mps = shaken.velocity_W_mps;
    start.attitude_WB = shaken.attitude_WB;
    start.body_rate_B_radps = shaken.body_rate_B_radps;
    rollout.begin(start, rotor_speeds);
    for (std::size_t h = 0; h < window.targets.size(); ++h) {
      Measured seen;
      finite = finite && rollout.run_to(motion.time_s(window.targets[h]), seen);
      const Measured exact = noisy(predicted[h], motion.noise(), window.row, static_cast<std::uint32_t>(h + 1));
      write(&FitErrors::Quantity::noise, index, h, finite ? distance(seen, exact) : Errors{nan, nan, nan, nan});
    }
  }

 private:
  // what the log does not have is not compared
  void write(std::vector<double> FitErrors::Quantity::*kind, std::size_t window, std::size_t horizon, Errors values) {
    const RecordedMotion& motion = recording_.motion;
    if (!motion.has_position()) values[0] = nan;
    if (!motion.has_velocity()) values[1] = nan;
    if (recording_.collective_only) values[2] = nan;
    if (!motion.has_body_rate() || recording_.collective_only) values[3] = nan;
    for (std::size_t q = 0; q < values.size(); ++q)
      (errors_.quantities[q].*kind)[window * options_.horizon_s.size() + horizon] = values[q];
  }

  const Recording& recording_;
  const ReplayOptions& options_;
  const std::vector<Window>& windows_;
  FitErrors& errors_;
};

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> common_windows(const FitErrors& one, const FitErrors& other) {
  std::vector<std::pair<std::size_t, std::size_t>> common;
  for (std::size_t a = 0, b = 0; a < one.windows() && b < other.windows();) {
    if (one.start_row[a] == other.start_row[b]) common.emplace_back(a++, b++);
    else one.start_row[a] < other.start_row[b] ? ++a : ++b;
  }
  return common;
}

FitErrors replay(const FlightLog& log, const VehicleModel& vehicle, const std::vector<EffectSpec>& effects,
                 const ReplayOptions& options) {
  return replay(Recording(log, vehicle, options), effects, options);
}

FitErrors replay(const Recording& recording, const std::vector<EffectSpec>& effects, const ReplayOptions& options) {
  Rollout scout(recording, effects);
  const std::vector<RotorArray> rotor_speeds = scout.rotor_speeds();
  const std::vector<Window> windows = find_windows(recording.motion, options, scout.pose_delay_s());
  // a window ends at the sample that is nearest to its horizon, which is not the one where it starts
  const double sample_s = recording.motion.sample_s();
  if (windows.empty() && options.horizon_s.front() < 0.5 * sample_s)
    throw DataError(
        fmt::format("{}: a horizon of {} s is shorter than a sample of {:.3g} s (nothing lies between); "
                    "ask for {:.3g} s or more",
                    recording.log.path, options.horizon_s.front(), sample_s, sample_s));
  if (windows.empty())
    throw DataError(
        fmt::format("{}: no unbroken stretch of {} s to replay", recording.log.path, options.horizon_s.back()));

  FitErrors errors;
  errors.horizon_s = options.horizon_s;
  for (const Window& window : windows) errors.start_row.push_back(window.row);
  const std::size_t size = windows.size() * options.horizon_s.size();
  for (FitErrors::Quantity& quantity : errors.quantities) {
    quantity.hold.resize(size);
    quantity.model.resize(size);
    if (options.with_noise) quantity.noise.resize(size);
  }
  const PerFlightFit per_flight(recording, effects, rotor_speeds, options.fit_per_flight, options.jobs);
  // every window has its own place in the result, whatever thread it runs on
  Replayer replayer(recording, options, windows, errors);
  const std::size_t tasks = (windows.size() + windows_per_task - 1) / windows_per_task;
  parallel_for(static_cast<std::int64_t>(tasks), options.jobs, [&](std::int64_t task) {
    const std::size_t first = static_cast<std::size_t>(task) * windows_per_task;
    std::optional<Rollout> rollout;
    std::size_t known = 0;
    for (std::size_t i = first; i < std::min(first + windows_per_task, windows.size()); ++i) {
      // another model only where more is known of the flight
      const std::size_t now_known = per_flight.known_by(windows[i].row);
      if (!rollout || now_known != known) rollout.emplace(recording, per_flight.effects(known = now_known));
      replayer.replay(*rollout, rotor_speeds, i);
    }
  });
  return errors;
}

nlohmann::ordered_json fit_block(const std::vector<FitErrors>& before, const std::vector<FitErrors>& after,
                                 const std::vector<FitErrors>& physics) {
  using nlohmann::ordered_json;
  const std::vector<double>& horizon_s = before.front().horizon_s;
  std::size_t windows = 0;
  for (const FitErrors& flight : before) windows += flight.windows();
  const auto means = [&](const std::vector<FitErrors>& flights, std::size_t q,
                         std::vector<double> FitErrors::Quantity::*kind) {
    ordered_json result = ordered_json::array();
    for (std::size_t h = 0; h < horizon_s.size(); ++h) {
      double sum = 0.0;
      for (const FitErrors& flight : flights)
        for (std::size_t i = 0; i < flight.windows(); ++i)
          sum += (flight.quantities[q].*kind)[i * horizon_s.size() + h];
      const double mean = sum / static_cast<double>(windows);
      result.push_back(std::isfinite(mean) ? ordered_json(mean) : ordered_json(nullptr));
    }
    return result;
  };
  ordered_json block{{"horizon_s", horizon_s}, {"windows", windows}};
  for (std::size_t q = 0; q < fit_quantity_names.size(); ++q) {
    ordered_json& quantity = block[std::string(fit_quantity_names[q])];
    quantity["hold"] = means(before, q, &FitErrors::Quantity::hold);
    quantity["before"] = means(before, q, &FitErrors::Quantity::model);
    if (!after.empty()) quantity["after"] = means(after, q, &FitErrors::Quantity::model);
    if (!physics.empty()) quantity["after_physics"] = means(physics, q, &FitErrors::Quantity::model);
    quantity["noise"] = means(before, q, &FitErrors::Quantity::noise);
  }
  return block;
}

}  // namespace gustlab::diagnosis
