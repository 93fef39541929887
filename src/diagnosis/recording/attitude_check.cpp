#include "diagnosis/recording/attitude_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "gustlab/types.hpp"

namespace gustlab::diagnosis {

namespace {

using Vector2 = Eigen::Vector2d;

constexpr double gravity_mps2 = 9.81;
constexpr double window_s = 0.4;
constexpr std::size_t least_windows = 20;
constexpr double least_acceleration_mps2 = 0.05;  // rms: less is drift and noise
constexpr double too_much = 0.4;                  // share of the acceleration that is left over
constexpr double clearly_better = 0.25;

struct Reading {
  const char* says;
  bool scalar_last, world_to_body;
};
constexpr Reading readings[] = {{"", false, false},
                                {"scalar-last", true, false},
                                {"world-to-body", false, true},
                                {"scalar-last and world-to-body", true, true}};

// columns that are all there; else none
std::vector<const std::vector<double>*> columns_of(const FlightLog& log, std::initializer_list<const char*> names) {
  std::vector<const std::vector<double>*> result;
  for (const char* name : names) {
    result.push_back(log.find(name));
    if (!result.back()) return {};
  }
  return result;
}

// horizontal part of the body's z axis in W
Vector2 lean(const double (&c)[4], const Reading& reading) {
  const Quaternion q = reading.scalar_last ? Quaternion(c[3], c[0], c[1], c[2]) : Quaternion(c[0], c[1], c[2], c[3]);
  return ((reading.world_to_body ? q.conjugate() : q) * Vector3::UnitZ()).head<2>();
}

}  // namespace

std::vector<LogFinding> check_attitude(const FlightLog& log) {
  const auto q = columns_of(log, {"qw", "qx", "qy", "qz"}), v = columns_of(log, {"vx", "vy"});
  if (q.empty() || v.empty()) return {};
  // per window: mean acceleration, and g times the mean lean of each reading
  std::vector<Vector2> acceleration;
  std::vector<Vector2> leaning[std::size(readings)];
  for (std::size_t first = 0, last = 0; first < log.rows(); first = last) {
    Vector2 sum[std::size(readings)] = {Vector2::Zero(), Vector2::Zero(), Vector2::Zero(), Vector2::Zero()};
    for (last = first; last + 1 < log.rows() && log.time_s[last] - log.time_s[first] < window_s; ++last) {
      const double c[4] = {(*q[0])[last], (*q[1])[last], (*q[2])[last], (*q[3])[last]};
      for (std::size_t r = 0; r < std::size(readings); ++r) sum[r] += lean(c, readings[r]);
    }
    if (last == first) break;
    const double length_s = log.time_s[last] - log.time_s[first];
    const Vector2 change((*v[0])[last] - (*v[0])[first], (*v[1])[last] - (*v[1])[first]);
    // a sample that is missing makes the sum NaN, a gap the window long
    if (!change.allFinite() || !sum[0].allFinite() || length_s > 1.5 * window_s) continue;
    acceleration.emplace_back(change / length_s);
    for (std::size_t r = 0; r < std::size(readings); ++r)
      leaning[r].emplace_back(gravity_mps2 / static_cast<double>(last - first) * sum[r]);
  }
  if (acceleration.size() < least_windows) return {};

  // mean square about the mean: a steady wind or a trim does not count
  const auto mean_square = [&](const auto& value) {
    Vector2 mean = Vector2::Zero();
    double square = 0.0;
    const double count = static_cast<double>(acceleration.size());
    for (std::size_t k = 0; k < acceleration.size(); ++k) mean += value(k) / count;
    for (std::size_t k = 0; k < acceleration.size(); ++k) square += (value(k) - mean).squaredNorm() / count;
    return square;
  };
  const double all = mean_square([&](std::size_t k) { return acceleration[k]; });
  if (all < least_acceleration_mps2 * least_acceleration_mps2) return {};
  const auto left = [&](std::size_t r) { return mean_square([&, r](std::size_t k) -> Vector2 { return acceleration[k] - leaning[r][k]; }) / all; };
  const double as_read = left(0);
  std::size_t best = 0;
  for (std::size_t r = 1; r < std::size(readings); ++r)
    if (left(r) < (best == 0 ? clearly_better * std::min(1.0, as_read) : left(best))) best = r;
  if (as_read < too_much || best == 0) return {};
  const std::string file = log.path.substr(log.path.find_last_of('/') + 1);
  return {{file, "qw…qz", "inconsistent", log.time_s.front(), log.time_s.back(),
           fmt::format("the vehicle does not accelerate as its attitude leans, and would if the quaternion were {}: set aside",
                       readings[best].says),
           true, false}};
}

}  // namespace gustlab::diagnosis
