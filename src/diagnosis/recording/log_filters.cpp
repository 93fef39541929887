#include "diagnosis/recording/log_filters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

namespace gustlab::diagnosis {

namespace {

// Of the sum of squared fifth over that of squared third differences, which is 252/20 = 12.6 of white noise. Measured (nine families
// of recorded flights, rows 10 ms apart): poses as they were measured 9.4 to 13.1, smoothed ones 0.1 to 6.3; accelerometers 8.2 to
// 12.6 and 0.2 to 3.6.
constexpr double most_of_filtered = 3.0, most_of_smooth_pose = 8.0, most_of_smooth_force = 5.0;
constexpr double thinned_s = 0.01;

// of rows `stride` apart
double roughness(const std::vector<double>& y, std::size_t stride = 1) {
  double third = 0.0, fifth = 0.0;
  for (std::size_t k = 5 * stride; k < y.size(); ++k) {
    const auto back = [&](std::size_t rows) { return y[k - rows * stride]; };
    const double d3 = back(0) - 3.0 * back(1) + 3.0 * back(2) - back(3);
    const double d5 = back(0) - 5.0 * back(1) + 10.0 * back(2) - 10.0 * back(3) + 5.0 * back(4) - back(5);
    if (!std::isfinite(d5)) continue;
    third += d3 * d3;
    fifth += d5 * d5;
  }
  return third > 0.0 ? fifth / third : std::numeric_limits<double>::infinity();
}

// every column that is wanted, and there is one
template <class Wanted>
bool all_below(const FlightLog& log, double most, std::size_t stride, Wanted wanted) {
  std::size_t seen = 0, below = 0;
  for (const LogColumn& column : log.columns)
    if (wanted(column.name)) {
      ++seen;
      below += roughness(column.values, stride) < most ? 1 : 0;
    }
  return seen > 0 && below == seen;
}

template <std::size_t count>
auto one_of(const std::array<std::string_view, count>& names) {
  return [&names](std::string_view name) { return std::find(names.begin(), names.end(), name) != names.end(); };
}

constexpr std::array<std::string_view, 8> motion = {"px", "py", "pz", "qx", "qy", "wx", "wy", "wz"};
constexpr std::array<std::string_view, 5> pose = {"px", "py", "pz", "qx", "qy"};
constexpr std::array<std::string_view, 3> force = {"ax", "ay", "az"};

}  // namespace

bool motion_filtered(const FlightLog& log) {
  if (log.meta.source == "simulation") return false;
  if (all_below(log, most_of_filtered, 1, one_of(motion))) return true;
  // in faster logs what was written after the filter, rounding say, is rough again
  if (log.time_s.size() < 2) return false;
  const double step_s = (log.time_s.back() - log.time_s.front()) / static_cast<double>(log.time_s.size() - 1);
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(thinned_s / step_s)));
  return all_below(log, most_of_smooth_pose, stride, one_of(pose)) &&
         all_below(log, most_of_smooth_force, stride, one_of(force));
}

bool commands_filtered(const FlightLog& log) { return all_below(log, most_of_filtered, 1, is_rotor_column); }

}  // namespace gustlab::diagnosis
