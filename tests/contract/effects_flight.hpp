// A lively open-loop flight near every surface, for contracts that hold for each row of the registry of effects.
#pragma once

#include <gmock/gmock.h>

#include <cmath>

#include "plant/plant.hpp"
#include "support/effects.hpp"

namespace gustlab::test {

inline constexpr double step_s = 0.002;

inline VehicleModel lively_vehicle() {
  VehicleModel vehicle = small_quadrotor();
  vehicle.environment.ground_z_m = 0.0;
  vehicle.environment.ceiling_z_m = 1.0;
  vehicle.environment.walls = {{{1.5, 0.0, 0.0}, {-1.0, 0.0, 0.0}}, {{0.0, -1.2, 0.0}, {0.0, 1.0, 0.0}}};
  return vehicle;
}

inline VehicleState lively_start(const VehicleModel& vehicle) {
  VehicleState state;
  state.position_W_m = {0.2, 0.1, 0.4};
  state.velocity_W_mps = {1.2, -0.7, 0.3};
  state.attitude_WB = Quaternion(Eigen::AngleAxisd(0.4, Vector3::UnitZ()) * Eigen::AngleAxisd(0.1, Vector3::UnitY()));
  state.body_rate_B_radps = {0.5, -0.4, 0.8};
  for (std::size_t i = 0; i < 4; ++i) state.rotor_speed_radps[i] = vehicle.hover_speed_radps();
  return state;
}

// hover plus a sinusoid of its own frequency on each rotor
inline RotorCommand lively_command(const VehicleModel& vehicle, std::int64_t step) {
  constexpr double frequency_Hz[] = {1.7, 2.9, 4.3, 6.1}, phase[] = {0.0, 1.0, 2.5, 4.0};
  RotorCommand command;
  for (std::size_t i = 0; i < 4; ++i)
    command.speed_radps[i] =
        vehicle.hover_speed_radps() *
        (1.0 + 0.06 * std::sin(2 * pi * frequency_Hz[i] * step_s * static_cast<double>(step) + phase[i]));
  return command;
}

struct FlightOptions {
  bool with_voltage = true;
  std::uint64_t seed = 7;
  VehicleModel vehicle = lively_vehicle();
  VehicleState start = lively_start(vehicle);
};

class Flight {
 public:
  Flight(std::vector<NamedEffect> effects, const FlightOptions& options = {})
      : vehicle_(options.vehicle),
        plant_(options.vehicle, std::move(effects), {.step_s = step_s, .seed = options.seed}) {
    if (options.with_voltage) plant_.set_voltage(3.6);
    plant_.reset(options.start);
  }

  Plant& plant() { return plant_; }

  // flies on, and appends what is true and what is seen after every step
  void fly(double seconds, std::vector<Observation>& seen, std::vector<VehicleState>& truth) {
    for (int k = 0; k < std::lround(seconds / step_s); ++k) {
      ASSERT_TRUE(plant_.step(lively_command(vehicle_, plant_.steps())));
      seen.push_back(plant_.observe(true));
      truth.push_back(plant_.state());
    }
  }

  // the same as plain numbers
  std::vector<double> numbers(double seconds) {
    std::vector<Observation> seen;
    std::vector<VehicleState> truth;
    fly(seconds, seen, truth);
    std::vector<double> out;
    const auto append = [&out](const auto& vector) {
      out.insert(out.end(), vector.data(), vector.data() + vector.size());
    };
    for (std::size_t k = 0; k < seen.size(); ++k) {
      append(truth[k].position_W_m), append(truth[k].velocity_W_mps), append(truth[k].attitude_WB.coeffs());
      append(truth[k].body_rate_B_radps), append(truth[k].rotor_speed_radps);
      append(seen[k].position_W_m), append(seen[k].velocity_W_mps), append(seen[k].attitude_WB.coeffs());
      append(seen[k].body_rate_B_radps), append(seen[k].specific_force_B_mps2);
    }
    return out;
  }

 private:
  VehicleModel vehicle_;
  Plant plant_;
};

inline double scale_of(Scale scale, const VehicleModel& vehicle) {
  switch (scale) {
    case Scale::one:
      return 1.0;
    case Scale::weight:
      return vehicle.weight_N();
    case Scale::arm:
      return vehicle.arm_m();
    case Scale::rotor_torque_per_speed:
      return vehicle.weight_N() * vehicle.arm_m() / (4 * vehicle.hover_speed_radps());
    case Scale::yaw_inertia:
      return vehicle.inertia_B_kgm2(2, 2);
    case Scale::weight_per_inflow:
      return std::sqrt(2.0 * 1.225 * vehicle.rotor_count * pi * std::pow(vehicle.rotor_radius_m, 2) *
                       vehicle.weight_N());
  }
  return 1.0;
}

// an effect at its natural size; what has none is given here
inline Values natural_values(const EffectRow& row, const VehicleModel& vehicle) {
  if (row.name == "saturation") return {{"max_speed", 2000.0}, {"dead_zone", 0.05}};
  if (row.name == "measurement_noise")
    return {{"position_sd", 0.001}, {"velocity_sd", 0.01},     {"attitude_sd", 0.002},
            {"rate_sd", 0.05},      {"accelerometer_sd", 0.2}, {"rate_bias.x", 0.1}};
  if (row.name == "fans") return {{"center_speed_mps", 1.2}, {"edge_speed_mps", 2.0}, {"turbulence", 0.4}};
  Values values;
  for (const Declared& parameter : parameters_of(*row.make()))
    if (parameter.info.natural > 0.0)
      values[parameter.name] = parameter.info.natural * scale_of(parameter.info.scale, vehicle);
  if (row.name == "gust") {
    values["limit_N"] = 0.03, values["rate_limit_Nps"] = 0.3, values["torque_sigma_xy"] = 1e-5;
    values["on_s"] = 0.5, values["off_s"] = 0.3;
  }
  return values;
}

// the effect alone, with what it needs to act: wind needs drag
inline std::vector<NamedEffect> planted(const EffectRow& row, const Values& values) {
  std::vector<NamedEffect> effects;
  effects.push_back(make_effect(row, values));
  if (row.name == "steady_wind" || row.name == "fans")
    for (NamedEffect& air :
         make_effect_list({{"rotor_drag", {{"at_hover", 0.01}}}, {"quadratic_drag", {{"area_xy", 0.01}}}}))
      effects.push_back(std::move(air));
  return effects;
}

inline std::vector<std::string_view> effect_names() {
  std::vector<std::string_view> names;
  for (const EffectRow& row : effect_registry()) names.push_back(row.name);
  return names;
}

}  // namespace gustlab::test
