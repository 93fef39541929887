#include "diagnosis/recording/log_filters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace gustlab::diagnosis {

namespace {

// of white noise, the sum of squared fifth over that of squared third differences is 252/20 = 12.6
constexpr double most_of_filtered = 3.0;

bool looks_filtered(const std::vector<double>& y) {
  double third = 0.0, fifth = 0.0;
  for (std::size_t k = 5; k < y.size(); ++k) {
    const double d3 = y[k] - 3.0 * y[k - 1] + 3.0 * y[k - 2] - y[k - 3];
    const double d5 = y[k] - 5.0 * y[k - 1] + 10.0 * y[k - 2] - 10.0 * y[k - 3] + 5.0 * y[k - 4] - y[k - 5];
    if (!std::isfinite(d5)) continue;
    third += d3 * d3;
    fifth += d5 * d5;
  }
  return third > 0.0 && fifth / third < most_of_filtered;
}

template <class Wanted>
bool all_filtered(const FlightLog& log, Wanted wanted) {
  std::size_t seen = 0, told = 0;
  for (const LogColumn& column : log.columns)
    if (wanted(column.name)) {
      ++seen;
      told += looks_filtered(column.values) ? 1 : 0;
    }
  return seen > 0 && told == seen;
}

}  // namespace

bool motion_filtered(const FlightLog& log) {
  constexpr std::array<std::string_view, 8> motion = {"px", "py", "pz", "qx", "qy", "wx", "wy", "wz"};
  return all_filtered(
      log, [&](std::string_view name) { return std::find(motion.begin(), motion.end(), name) != motion.end(); });
}

bool commands_filtered(const FlightLog& log) { return all_filtered(log, is_rotor_column); }

}  // namespace gustlab::diagnosis
