// Concealed trials for tests of the diagnosis: short flights of our own plant in calm but not still air, recorded at every
// command with the noise of a motion-capture room.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "diagnosis/diagnose.hpp"
#include "simulation/concealed_trials.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::test {

struct TrialSettings {
  std::string vehicle = "crazyflie", controller = "geometric";
  std::vector<std::string> fit = {}, holdout = {};  // trajectories
  std::vector<std::string> sensors{"pose", "gyroscope"};
  double duration_s = 14.0, step_s = 0.002, log_rate_hz = 0.0;  // 0: every command
  double noise = 1.0;                                           // of the sensors, times that of a motion-capture room
  double air_sd_N = 0.002;
  std::string tables = {};     // [trajectory.*], [environment]
  std::string concealed = {};  // as {type = "mass", delta = 0.06}
};

// Flies the trial and says how to diagnose its recordings, with two threads.
inline diagnosis::DiagnoseOptions fly_trial(const TemporaryFolder& folder, const TrialSettings& trial) {
  std::vector<std::string> trajectories = trial.fit;
  for (const std::string& name : trial.holdout)
    if (std::find(trajectories.begin(), trajectories.end(), name) == trajectories.end()) trajectories.push_back(name);
  const auto list = [](const std::vector<std::string>& names) {
    return fmt::format("[\"{}\"]", fmt::join(names, "\", \""));
  };
  const std::string text = fmt::format(
      R"(
format = "gustlab-trials/1"
name = "test"
vehicle = "{}"
trajectories = {}
controllers = ["{}"]
fit = {}
holdout = {}
sensors = {}
seed = 7
duration_s = {}
step_s = {}
log_rate_hz = {}
{}
[[effect]]
type = "measurement_noise"
position_sd = {}
velocity_sd = {}
attitude_sd = {}
rate_sd = {}
accelerometer_sd = {}
[[effect]]
type = "gust"
sigma_xy = {}
sigma_z = {}
correlation_time = 0.15
[[trial]]
name = "trial"
effects = [{}]
)",
      trial.vehicle, list(trajectories), trial.controller, list(trial.fit), list(trial.holdout), list(trial.sensors),
      trial.duration_s, trial.step_s, trial.log_rate_hz, trial.tables, 0.0005 * trial.noise, 0.01 * trial.noise,
      0.002 * trial.noise, 0.01 * trial.noise, 0.1 * trial.noise, trial.air_sd_N, trial.air_sd_N, trial.concealed);
  fly_concealed_trials(read_trials_file(folder.write("trials.toml", text)), folder.file("flights"), 2);
  const auto files = [&](const char* role, std::size_t count) {
    std::vector<std::string> paths;
    for (std::size_t n = 1; n <= count; ++n)
      paths.push_back(fmt::format("{}/trial/{}_{}.csv", folder.file("flights"), role, n));
    return paths;
  };
  diagnosis::DiagnoseOptions options;
  options.fit = files("fit", trial.fit.size());
  options.holdout = files("holdout", trial.holdout.size());
  options.jobs = 2;
  return options;
}

// A parameter of a finding; a failure when it has none of this name.
inline double value_of(const diagnosis::EffectFinding& effect, const std::string& name) {
  for (const diagnosis::NamedValue& v : effect.parameters)
    if (v.name == name) return v.value;
  ADD_FAILURE() << effect.effect << " has no " << name;
  return 0.0;
}

// Changes, in every recording of the trial, the columns that are wanted.
template <class Wanted, class How>
void change(const diagnosis::DiagnoseOptions& trial, Wanted wanted, How how) {
  for (const auto* paths : {&trial.fit, &trial.holdout})
    for (const std::string& path : *paths) {
      FlightLog log = read_flight_log(path);
      for (LogColumn& column : log.columns)
        if (wanted(column.name)) how(log, column.values);
      write_flight_log(log, path);
    }
}

inline auto begins(char initial) {
  return [initial](const std::string& column) { return column[0] == initial; };
}

// Columns of this initial `by_s` later, between samples.
inline void delay(const diagnosis::DiagnoseOptions& trial, char initial, double by_s) {
  change(trial, begins(initial), [by_s](const FlightLog& log, std::vector<double>& values) {
    const std::vector<double> from = values;
    for (std::size_t k = 0; k < from.size(); ++k) {
      const double at = (log.time_s[k] - by_s - log.time_s.front()) / (log.time_s[1] - log.time_s[0]);
      const auto before = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(from.size() - 2)));
      values[k] = from[before] + (at - static_cast<double>(before)) * (from[before + 1] - from[before]);
    }
  });
}

}  // namespace gustlab::test
