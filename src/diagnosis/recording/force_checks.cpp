#include "diagnosis/recording/force_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double mean_window_s = 0.25;  // over which vibration averages out
constexpr std::size_t least_means = 8;
constexpr double most_off = 2.5;            // of a scale, when only the vehicle file says how large a force is
constexpr double most_off_of_motion = 1.3;  // when the motion does
constexpr double near = 0.02, not_near = 0.5, clearly_nearer = 0.25;  // shares of squares
constexpr double least_ratio = 0.5, most_ratio = 2.0, most_of_any_flight = 5.0;

// means over a window, m/s²
struct WindowMeans {
  Vector3 measured_B = Vector3::Zero();  // by the accelerometer
  Vector3 needed_B = Vector3::Zero();    // by the motion; without a pose what the inputs push
  Vector3 needed_W = Vector3::Zero();    // the same in W
  Vector3 gravity_B = Vector3::Zero(), gravity_W = Vector3::Zero();  // what of it holds the vehicle up
  double commanded = 0.0;                                            // thrust of the inputs per mass
};

struct Windows {
  std::vector<WindowMeans> all;
  bool by_motion = false, with_accelerometer = false;
};

double thrust_per_mass(const CommandRecord& record, const VehicleModel& vehicle, double time_s, double interval_s) {
  return thrust_N(vehicle, record.mean(time_s, time_s + interval_s)) / vehicle.mass_kg;
}

Windows windows_of(const FlightLog& log, const VehicleModel& vehicle) {
  const FlightData data = prepare_flight(log, vehicle, {.linear_hold = false, .max_rate_hz = 1e6});
  const CommandRecord& record = data.rotor_record();
  Windows result;
  result.by_motion = log.find("qw") && (log.find("px") || log.find("vx"));
  result.with_accelerometer = log.find("ax") && log.find("ay") && log.find("az");
  const Vector3 gravity_W(0.0, 0.0, vehicle.gravity_mps2);
  for (std::size_t first = 0, last = 0; first < data.samples.size(); first = last) {
    WindowMeans window;
    double count = 0.0, felt = 0.0;
    const double from_s = data.samples[first].time_s;
    for (last = first; last < data.samples.size() && data.samples[last].time_s < from_s + mean_window_s; ++last) {
      const Sample& sample = data.samples[last];
      const Motion& motion = data.motion[last];
      const Quaternion to_B = motion.attitude_WB.conjugate();
      const double commanded = thrust_per_mass(record, vehicle, sample.time_s, data.sample_s);
      window.commanded += commanded;
      window.needed_W += result.by_motion ? Vector3(motion.acceleration_W_mps2 + gravity_W)
                                          : Vector3(motion.attitude_WB * Vector3(0.0, 0.0, commanded));
      window.needed_B +=
          result.by_motion ? to_B * (motion.acceleration_W_mps2 + gravity_W) : Vector3(0.0, 0.0, commanded);
      window.gravity_B += to_B * gravity_W;
      window.gravity_W += gravity_W;
      count += 1.0;
      if (!(sample.channels & has_force)) continue;
      window.measured_B += sample.specific_force_B_mps2;
      felt += 1.0;
    }
    if (count < 2.0 || (result.with_accelerometer && felt == 0.0)) continue;
    for (Vector3* sum : {&window.needed_W, &window.needed_B, &window.gravity_B, &window.gravity_W}) *sum /= count;
    window.commanded /= count;
    if (felt > 0.0) window.measured_B /= felt;
    if (window.needed_B.allFinite() && window.measured_B.allFinite() && std::isfinite(window.commanded))
      result.all.push_back(window);
  }
  return result;
}

// squares that a reading of the accelerometer leaves, at the best scale within some factor
template <class Expected>
double left_by(const std::vector<WindowMeans>& windows, double factor, Expected expected) {
  double mm = 0.0, me = 0.0, ee = 0.0;
  for (const WindowMeans& w : windows) {
    const Vector3 e = expected(w);
    mm += w.measured_B.squaredNorm(), me += w.measured_B.dot(e), ee += e.squaredNorm();
  }
  const double scale = std::clamp(me / (ee + 1e-300), 1.0 / factor, factor);
  return mm - 2.0 * scale * me + scale * scale * ee;
}

struct OtherReading {
  const char *kind, *says;
  bool needs_motion;
  std::function<Vector3(const WindowMeans&)> expected;
};

std::optional<ForceFault> accelerometer_fault(const Windows& windows, double gravity_mps2) {
  const std::vector<OtherReading> others = {
      {"unit", "is in g, not in m/s²", false,
       [&](const WindowMeans& w) -> Vector3 { return w.needed_B / gravity_mps2; }},
      {"sign", "reads downward (a hover reads +9.81 along the body's z axis)", false,
       [](const WindowMeans& w) -> Vector3 { return -w.needed_B; }},
      {"frame", "is in axes x forward, y right, z down", false,
       [](const WindowMeans& w) { return Vector3(w.needed_B.x(), -w.needed_B.y(), -w.needed_B.z()); }},
      {"frame", "is in world axes, not in body axes", true, [](const WindowMeans& w) { return w.needed_W; }},
      {"inconsistent", "leaves gravity out", true,
       [](const WindowMeans& w) -> Vector3 { return w.needed_B - w.gravity_B; }},
      {"inconsistent", "is in world axes and leaves gravity out", true,
       [](const WindowMeans& w) -> Vector3 { return w.needed_W - w.gravity_W; }}};
  const double factor = windows.by_motion ? most_off_of_motion : most_off;
  const double as_read = left_by(windows.all, factor, [](const WindowMeans& w) { return w.needed_B; });
  double needed = 0.0;
  for (const WindowMeans& w : windows.all) needed += w.needed_B.squaredNorm();
  if (as_read < near * needed) return std::nullopt;
  const OtherReading* best = nullptr;
  double least = clearly_nearer * as_read;
  for (const OtherReading& other : others) {
    if (other.needs_motion && !windows.by_motion) continue;
    if (const double left = left_by(windows.all, factor, other.expected); left < least) least = left, best = &other;
  }
  if (best) return ForceFault{"ax…az", best->kind, fmt::format("the accelerometer {}: not used", best->says), true};
  if (as_read < not_near * needed) return std::nullopt;
  return ForceFault{
      "ax…az", "inconsistent",
      fmt::format("the accelerometer does not show the specific force that the recorded {} needs: not used",
                  windows.by_motion ? "motion" : "thrust"),
      true};
}

std::optional<ForceFault> thrust_fault(const Windows& windows, bool accelerometer_is_fine, double gravity_mps2) {
  double commanded = 0.0, needed = 0.0;
  for (const WindowMeans& w : windows.all) {
    commanded += w.commanded;
    needed += windows.by_motion ? w.needed_B.z() : accelerometer_is_fine ? w.measured_B.z() : gravity_mps2;
  }
  const bool of_any_flight = !windows.by_motion && !accelerometer_is_fine;
  const double ratio = commanded / needed;
  if (ratio > least_ratio && ratio < (of_any_flight ? most_of_any_flight : most_ratio)) return std::nullopt;
  return ForceFault{
      "u1…uN", "inconsistent",
      fmt::format("the inputs mean {:.2f} times the thrust that {} needs: is it the right vehicle and the right unit?",
                  ratio, of_any_flight ? "a hover" : "the recorded motion"),
      false};
}

}  // namespace

std::vector<ForceFault> check_forces(const FlightLog& log, const VehicleModel& vehicle) {
  const Windows windows = windows_of(log, vehicle);
  if (windows.all.size() < least_means) return {};
  std::vector<ForceFault> faults;
  const auto add = [&](std::optional<ForceFault> fault) {
    if (fault) faults.push_back(*std::move(fault));
  };
  if (windows.with_accelerometer) add(accelerometer_fault(windows, vehicle.gravity_mps2));
  add(thrust_fault(windows, windows.with_accelerometer && faults.empty(), vehicle.gravity_mps2));
  return faults;
}

}  // namespace gustlab::diagnosis
