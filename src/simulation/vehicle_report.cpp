#include "simulation/vehicle_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/text.hpp"
#include "config/toml.hpp"
#include "control/rotors.hpp"
#include "simulation/recorder.hpp"

namespace gustlab {

namespace {

constexpr double hover_s = 10.0;

Experiment hover_of(const VehicleModel& vehicle) {
  config::Table document = config::Table::parse(
      fmt::format(
          "name = \"hover\"\nvehicle = {}\ntrajectories = [\"hover\"]\ncontrollers = [\"geometric\"]\nduration_s = {}\n"
          "step_s = 0.0005\nlog_source = \"truth\"\n",
          config::quoted(std::filesystem::absolute(vehicle.source_path).string()), hover_s),
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

}  // namespace

VehicleReport examine_vehicle(const VehicleModel& vehicle) {
  VehicleReport report;
  report.mass_kg = vehicle.mass_kg;
  report.weight_N = vehicle.weight_N();
  report.arm_m = vehicle.arm_m();
  const Mixer mixer(vehicle);
  report.authority_radps2 = (vehicle.inertia_B_kgm2.inverse() * mixer.torque_authority_B_Nm()).cwiseAbs();
  if (std::isfinite(vehicle.max_speed_radps)) {
    RotorArray most{};
    std::fill_n(most.begin(), vehicle.rotor_count, vehicle.max_speed_radps);
    report.thrust_to_weight = mixer.force_B_N(most).z() / vehicle.weight_N();
  }
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
