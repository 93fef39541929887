// Logs that were low-pass filtered before they were written are told from logs of noisy sensors.
#include "diagnosis/recording/log_filters.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace gustlab::diagnosis {
namespace log_filters_test {

// 20 s of slow motion with white noise in every column, as a Gaussian filter (standard deviation, s; 0: none) leaves it, then
// rounded to a step
FlightLog recorded(double rate_hz, double filter_s, double rounded_to = 0.0) {
  FlightLog log;
  const auto rows = static_cast<std::size_t>(20.0 * rate_hz);
  for (std::size_t k = 0; k < rows; ++k) log.time_s.push_back(static_cast<double>(k) / rate_hz);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (const char* name : {"px", "py", "pz", "qx", "qy", "wx", "wy", "wz", "ax", "ay", "az"}) {
    std::vector<double> raw(rows), value(rows);
    for (std::size_t k = 0; k < rows; ++k) raw[k] = std::sin(2.0 * log.time_s[k]) + 0.01 * normal(random);
    const auto reach = static_cast<std::ptrdiff_t>(4.0 * filter_s * rate_hz);
    for (std::ptrdiff_t k = 0; k < std::ssize(value); ++k) {
      double sum = 0.0, weight = 0.0;
      for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, k - reach); j <= std::min(k + reach, std::ssize(raw) - 1);
           ++j) {
        const double away = filter_s > 0.0 ? static_cast<double>(j - k) / (filter_s * rate_hz) : 0.0;
        sum += std::exp(-0.5 * away * away) * raw[static_cast<std::size_t>(j)], weight += std::exp(-0.5 * away * away);
      }
      const double smooth = sum / weight;
      value[static_cast<std::size_t>(k)] = rounded_to > 0.0 ? std::round(smooth / rounded_to) * rounded_to : smooth;
    }
    log.columns.push_back({name, std::move(value)});
  }
  return log;
}

TEST(LogFilters, NoiseOfSensorsIsNoFilter) {
  for (const double rate_hz : {50.0, 100.0, 250.0, 500.0}) EXPECT_FALSE(motion_filtered(recorded(rate_hz, 0.0)));
}

TEST(LogFilters, AFilteredLogIsTold) {
  for (const double rate_hz : {100.0, 250.0, 500.0}) EXPECT_TRUE(motion_filtered(recorded(rate_hz, 0.02)));
}

TEST(LogFilters, ASimulationIsSmoothWithoutAFilter) {
  FlightLog log = recorded(100.0, 0.02);
  log.meta.source = "simulation";
  EXPECT_FALSE(motion_filtered(log));
}

// in a fast log five figures are rough from row to row, though nothing is from one hundredth of a second to the next
TEST(LogFilters, RoundingAfterTheFilterDoesNotHideIt) {
  EXPECT_TRUE(motion_filtered(recorded(400.0, 0.02, 1e-5)));
  EXPECT_FALSE(motion_filtered(recorded(400.0, 0.0, 1e-5)));
}

// every column counts: one sensor whose noise was left is no filtered log
TEST(LogFilters, OneRoughColumnIsEnough) {
  FlightLog log = recorded(100.0, 0.02);
  log.columns.front() = recorded(100.0, 0.0).columns.front();
  EXPECT_FALSE(motion_filtered(log));
}

TEST(LogFilters, CommandsAreJudgedByThemselves) {
  const auto with_commands = [](double motion_s, double commands_s) {
    FlightLog log = recorded(100.0, motion_s);
    const FlightLog other = recorded(100.0, commands_s);
    for (std::size_t i = 0; i < 4; ++i) log.columns.push_back({"u" + std::to_string(i + 1), other.columns[i].values});
    return log;
  };
  for (const double motion_s : {0.0, 0.02}) {
    EXPECT_TRUE(commands_filtered(with_commands(motion_s, 0.02))) << motion_s;
    EXPECT_FALSE(commands_filtered(with_commands(motion_s, 0.0))) << motion_s;
  }
  EXPECT_FALSE(commands_filtered(recorded(100.0, 0.02)));
}

}  // namespace log_filters_test
}  // namespace gustlab::diagnosis
