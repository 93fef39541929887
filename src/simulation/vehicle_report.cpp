#include "simulation/vehicle_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/text.hpp"
#include "config/toml.hpp"
#include "control/rotors.hpp"
#include "plant/force_model.hpp"
#include "simulation/make_effects.hpp"
#include "simulation/recorder.hpp"

namespace gustlab {

namespace {

constexpr double hover_s = 10.0, step_s = 0.0005;

Experiment hover_of(const VehicleModel& vehicle) {
  config::Table document = config::Table::parse(
      fmt::format(
          "name = \"hover\"\nvehicle = {}\ntrajectories = [\"hover\"]\ncontrollers = [\"geometric\"]\nduration_s = {}\n"
          "step_s = {}\nlog_source = \"truth\"\n",
          config::quoted(std::filesystem::absolute(vehicle.source_path).string()), hover_s, step_s),
      "hover");
  return make_experiment(document, "");
}

double mean_of_last_half(const std::vector<double>& values) {
  const auto half = static_cast<std::ptrdiff_t>(values.size() / 2);
  double sum = 0.0;
  for (auto value = values.begin() + half; value != values.end(); ++value) sum += *value;
  return sum / static_cast<double>(static_cast<std::ptrdiff_t>(values.size()) - half);
}

// the input for which a map gives a speed; std::nullopt where it has none
std::optional<double> input_for(double speed_radps, const Rotor& rotor,
                                const std::optional<std::pair<double, double>>& line,
                                const std::optional<std::array<double, 3>>& thrust) {
  if (line) return (speed_radps - line->second) / line->first;
  if (!thrust) return std::nullopt;
  const auto& [c0, c1, c2] = *thrust;
  const double wanted_N = rotor.thrust_coefficient_Ns2 * speed_radps * speed_radps - c0;
  if (c2 == 0.0) return wanted_N / c1;
  return (-c1 + std::sqrt(std::max(c1 * c1 + 4.0 * c2 * wanted_N, 0.0))) / (2.0 * c2);
}

// a command that never changes
struct Steady final : Actuation::Past {
  explicit Steady(double speed_radps) { command_radps.fill(speed_radps); }
  void command(double, RotorArray& speed_radps) const override { speed_radps = command_radps; }
  RotorArray command_radps;
};

// upward force of all rotors at the largest command, standing in still air a metre above the ground
double most_thrust_N(const ForceModel& forces) {
  const VehicleModel& vehicle = forces.vehicle();
  const Steady most(vehicle.max_speed_radps);
  Actuation actuation{.voltage_V = vehicle.nominal_voltage_V,
                      .command_radps = most.command_radps,
                      .start_speed_radps = most.command_radps,
                      .past = &most};
  forces.actuate(actuation);
  VehicleState state;
  state.position_W_m.z() = 1.0;
  Flow flow = forces.flow(state, vehicle.nominal_voltage_V);
  RotorSet rotors;
  forces.rotors(actuation.end_speed_radps, {}, flow, rotors);
  double total_N = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i)
    total_N += rotors.thrust_N[i] * rotors.axis_B[i].z();
  return total_N;
}

}  // namespace

VehicleReport examine_vehicle(const VehicleModel& vehicle) {
  VehicleReport report;
  ForceModel forces(vehicle, make_flown_effects(vehicle.effects));
  forces.prepare(step_s, 0, 0);
  const VehicleModel& flown = forces.vehicle();
  report.mass_kg = flown.mass_kg;
  report.weight_N = flown.weight_N();
  report.arm_m = flown.arm_m();
  report.authority_radps2 = (flown.inertia_B_kgm2.inverse() * Mixer(flown).torque_authority_B_Nm()).cwiseAbs();
  if (std::isfinite(flown.max_speed_radps)) report.thrust_to_weight = most_thrust_N(forces) / flown.weight_N();
  for (const EffectSpec& effect : vehicle.effects)
    for (const auto& [key, value] : effect.values) {
      if (find_effect(effect.type)->latency != Latency::lag) continue;
      if (key == "time_constant") report.lag_up_s = std::stod(value);
      if (key == "time_constant_down") report.lag_down_s = std::stod(value);
    }
  report.unknown = unknown_numbers(vehicle);
  report.contradictions = contradictions(vehicle);

  const auto [record, log] = run_logged(hover_of(vehicle), {});
  report.outcome = record.outcome;
  report.flown_s = record.duration_s;
  if (record.outcome != Outcome::completed) {
    report.contradictions.push_back(
        fmt::format("the simulated hover {} after {:.2g} s", to_string(record.outcome), record.duration_s));
    return report;
  }
  report.error_m = std::sqrt(std::pow(mean_of_last_half(*log.find("px")) - mean_of_last_half(*log.find("rpx")), 2) +
                             std::pow(mean_of_last_half(*log.find("py")) - mean_of_last_half(*log.find("rpy")), 2) +
                             std::pow(mean_of_last_half(*log.find("pz")) - mean_of_last_half(*log.find("rpz")), 2));
  report.tilt_rad = 2.0 * std::hypot(mean_of_last_half(*log.find("qx")), mean_of_last_half(*log.find("qy")));
  for (int i = 0; i < vehicle.rotor_count; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    const double speed = mean_of_last_half(*log.find(fmt::format("u{}", i + 1)));
    report.trim.push_back({rotor.site, speed,
                           input_for(speed, rotor, vehicle.actuator.throttle_line, vehicle.actuator.throttle_thrust),
                           input_for(speed, rotor, vehicle.actuator.pwm_line, vehicle.actuator.pwm_thrust)});
  }
  return report;
}

}  // namespace gustlab
