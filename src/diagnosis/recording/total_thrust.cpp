#include "diagnosis/recording/total_thrust.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "plant/force_model.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double averaged_s = 2.0, longest_gap_s = 0.3;

// Mean thrust over each command's time, N, as the vehicle's own actuation makes it of these commands.
std::vector<double> made_N(const VehicleModel& vehicle, const ForceModel& forces, const std::vector<double>& time_s,
                           const std::vector<RotorArray>& command_radps) {
  std::vector<double> made(time_s.size());
  Actuation step;
  RotorArray speed = command_radps.front();
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    step.time_s = time_s[k] - time_s.front();
    step.step_s = k + 1 < time_s.size() ? time_s[k + 1] - time_s[k] : longest_gap_s;
    if (step.step_s >= longest_gap_s) step.step_s = longest_gap_s, speed = command_radps[k];
    step.command_radps = command_radps[k];
    step.start_speed_radps = speed;
    forces.actuate(step);
    made[k] = thrust_N(vehicle, step.mean_speed_radps);
    speed = step.end_speed_radps;
  }
  return made;
}

std::vector<double> running_mean(const std::vector<double>& time_s, const std::vector<double>& value, double width_s) {
  std::vector<double> mean(value.size());
  double sum = 0.0;
  for (std::size_t k = 0, from = 0, to = 0; k < value.size(); ++k) {
    while (to < value.size() && time_s[to] <= time_s[k] + 0.5 * width_s) sum += value[to++];
    while (time_s[from] < time_s[k] - 0.5 * width_s) sum -= value[from++];
    mean[k] = sum / static_cast<double>(to - from);
  }
  return mean;
}

// What the mean of each rotor's thrust gains over that of their sum: a motor that rises faster than it falls turns commands that jitter into
// thrust, of which their sum knows nothing.
void add_rectified(const VehicleModel& vehicle, const std::vector<double>& time_s,
                   const std::vector<RotorArray>& command_radps, std::vector<double>& total_N) {
  if (vehicle.effects.empty() || time_s.empty()) return;
  ForceModel forces(vehicle, make_flown_effects(vehicle.effects));
  forces.prepare(1e-3, 0, 0);
  std::vector<RotorArray> of_total;
  for (const double total : total_N)
    of_total.push_back(speeds_radps(vehicle, ActuatorKind::collective_thrust, [total](std::size_t) { return total; }));
  std::vector<double> gained = made_N(vehicle, forces, time_s, command_radps);
  const std::vector<double> of_sum = made_N(vehicle, forces, time_s, of_total);
  for (std::size_t k = 0; k < gained.size(); ++k) gained[k] -= of_sum[k];
  gained = running_mean(time_s, gained, averaged_s);
  for (std::size_t k = 0; k < gained.size(); ++k) total_N[k] = std::max(0.0, total_N[k] + gained[k]);
}

}  // namespace

FlightLog with_total_thrust(FlightLog log, const VehicleModel& vehicle) {
  std::vector<std::vector<double>*> input;
  for (LogColumn& column : log.columns) {
    if (column.name == "rotor1") return log;
    for (int i = 1; i <= vehicle.rotor_count; ++i)
      if (column.name == fmt::format("u{}", i)) input.push_back(&column.values);
  }
  if (input.size() != static_cast<std::size_t>(vehicle.rotor_count) ||
      log.meta.actuator == ActuatorKind::collective_thrust)
    return log;
  std::vector<std::size_t> row;  // those that have a command
  std::vector<double> time_s, total_N;
  std::vector<RotorArray> command_radps;
  for (std::size_t k = 0; k < log.rows(); ++k) {
    const RotorArray command = speeds_radps(vehicle, log.meta.actuator, [&](std::size_t i) { return (*input[i])[k]; });
    const double total = thrust_N(vehicle, command);
    if (std::isnan(total)) continue;
    row.push_back(k);
    time_s.push_back(log.time_s[k]);
    total_N.push_back(total);
    command_radps.push_back(command);
  }
  add_rectified(vehicle, time_s, command_radps, total_N);
  std::vector<double> total(log.rows(), std::nan(""));
  for (std::size_t j = 0; j < row.size(); ++j) total[row[j]] = total_N[j];
  *input.front() = std::move(total);
  log.meta.actuator = ActuatorKind::collective_thrust;
  std::erase_if(log.columns, [](const LogColumn& column) {
    return column.name.size() == 2 && column.name[0] == 'u' && column.name[1] != '1';
  });
  return log;
}

}  // namespace gustlab::diagnosis
