#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gustlab/effect.hpp"
#include "simulation/vehicle_report.hpp"
#include "vehicle/estimates.hpp"
#include "vehicle/gaps.hpp"

namespace gustlab {

namespace {

// an estimate and a number that differ by more than four standard deviations of the estimate (in its logarithm)
bool far_from(double value, double estimate, double spread) {
  return std::abs(std::log(value / estimate)) > 4.0 * spread;
}

void check_places(const VehicleModel& vehicle, std::vector<std::string>& said) {
  const auto hub = [&](int i) -> Vector3 { return vehicle.rotors[static_cast<std::size_t>(i)].position_B_m; };
  for (int i = 0; i < vehicle.rotor_count; ++i) {
    const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
    if (rotor.axis_B.z() < 0.5)
      said.push_back(fmt::format(
          "rotor {} ({}) does not push upwards: its axis is ({:.2g}, {:.2g}, {:.2g}); z of its site must point up",
          i + 1, rotor.site, rotor.axis_B.x(), rotor.axis_B.y(), rotor.axis_B.z()));
    for (int j = 0; j < i; ++j) {
      const double apart_m = (hub(i) - hub(j)).head<2>().norm();
      if ((hub(i) - hub(j)).norm() < 1e-6)
        said.push_back(fmt::format("rotors {} and {} are at the same place", j + 1, i + 1));
      else if (std::abs(hub(i).z() - hub(j).z()) < 1e-3 && apart_m < 1.9 * vehicle.rotor_radius_m)
        said.push_back(fmt::format("propellers {} and {} overlap: their hubs are {:.3g} m apart and radius_m is {:.3g}",
                                   j + 1, i + 1, apart_m, vehicle.rotor_radius_m));
    }
  }
}

// equal rotors that carry the weight: what moment do they leave?
void check_balance(const VehicleModel& vehicle, std::vector<std::string>& said) {
  double turn = 0.0;
  for (int i = 0; i < vehicle.rotor_count; ++i) turn += vehicle.rotors[static_cast<std::size_t>(i)].direction;
  if (std::abs(turn) > 1.5)
    said.push_back(fmt::format("{} more rotors turn {} than the other way round: the vehicle yaws in hover",
                               std::abs(turn), turn > 0.0 ? "counter-clockwise" : "clockwise"));
  Vector3 middle = Vector3::Zero();
  for (int i = 0; i < vehicle.rotor_count; ++i)
    middle += vehicle.rotors[static_cast<std::size_t>(i)].position_B_m / vehicle.rotor_count;
  const double off_m = (vehicle.center_of_mass_B_m - middle).head<2>().norm();
  if (off_m > 0.3 * vehicle.arm_m())
    said.push_back(fmt::format("the centre of mass is {:.3g} m beside the middle of the rotors, with arms of {:.3g} m",
                               off_m, vehicle.arm_m()));
}

void check_sizes(const VehicleModel& vehicle, std::vector<std::string>& said) {
  const double square = vehicle.mass_kg * vehicle.arm_m() * vehicle.arm_m();
  for (int axis = 0; axis < 3; ++axis) {
    const double usual = (axis == 2 ? yaw_inertia_factor : tilt_inertia_factor) * square,
                 inertia = vehicle.inertia_B_kgm2(axis, axis);
    if (far_from(inertia, usual, inertia_spread))
      said.push_back(
          fmt::format("the moment of inertia about {} is {:.3g} kg m^2; a vehicle of {:.3g} kg with arms of {:.3g} m "
                      "usually has {:.2g} "
                      "(check units: kg, m, kg m^2)",
                      "xyz"[axis], inertia, vehicle.mass_kg, vehicle.arm_m(), usual));
  }
  const Rotor& rotor = vehicle.rotors[0];
  const double diameter_m = 2.0 * vehicle.rotor_radius_m;
  if (diameter_m == 0.0) return;
  const double coefficient = estimated_thrust_coefficient_Ns2(diameter_m),
               ratio = torque_ratio_per_diameter * diameter_m;
  if (vehicle.rotor_speed_known && far_from(rotor.thrust_coefficient_Ns2, coefficient, propeller_ct_spread))
    said.push_back(
        fmt::format("the thrust coefficient {:.3g} N/(rad/s)^2 is that of no propeller of {:.3g} m (usual: {:.2g}): "
                    "check its unit and radius_m",
                    rotor.thrust_coefficient_Ns2, diameter_m, coefficient));
  if (vehicle.torque_ratio_known && rotor.torque_ratio_m > 0.0 &&
      far_from(rotor.torque_ratio_m, ratio, torque_ratio_spread))
    said.push_back(fmt::format(
        "the torque ratio {:.3g} m is that of no propeller of {:.3g} m (usual: {:.2g}): it is torque over thrust, in m",
        rotor.torque_ratio_m, diameter_m, ratio));
  const double tip_mps = vehicle.hover_speed_radps() * vehicle.rotor_radius_m;
  if (vehicle.rotor_speed_known && tip_mps > 300.0)
    said.push_back(fmt::format(
        "in hover the propellers' tips move at {:.0f} m/s, near the speed of sound: check coefficient and radius_m",
        tip_mps));
}

void check_inputs(const VehicleModel& vehicle, std::vector<std::string>& said) {
  const auto full = [&](const char* input, double most, const auto& line, const auto& thrust) {
    const Rotor& rotor = vehicle.rotors[0];
    if (!line && !thrust) return;
    const double force_N = line ? rotor.thrust_coefficient_Ns2 * std::pow(line->first * most + line->second, 2)
                                : (*thrust)[0] + most * ((*thrust)[1] + most * (*thrust)[2]);
    const double weight = force_N * vehicle.rotor_count / vehicle.weight_N();
    if (weight < 1.05)
      said.push_back(
          fmt::format("at full {} the rotors carry {:.2g} of the weight: the vehicle does not fly", input, weight));
    if (weight > 20.0)
      said.push_back(fmt::format("at full {} the rotors push {:.3g} times the weight: check the map of [actuator]",
                                 input, weight));
  };
  full("throttle", 1.0, vehicle.actuator.throttle_line, vehicle.actuator.throttle_thrust);
  full("pwm", full_pwm, vehicle.actuator.pwm_line, vehicle.actuator.pwm_thrust);
}

}  // namespace

std::vector<std::string> contradictions(const VehicleModel& vehicle) {
  std::vector<std::string> said;
  check_places(vehicle, said);
  check_balance(vehicle, said);
  check_sizes(vehicle, said);
  check_inputs(vehicle, said);
  return said;
}

std::vector<std::string> unknown_numbers(const VehicleModel& vehicle) {
  std::vector<std::string> said;
  for (const VehicleGap& gap : gaps_of(vehicle)) {
    std::vector<std::string_view> effects;
    for (const EffectRow& row : effect_registry())
      if (row.asks(gap.need)) effects.push_back(row.name);
    said.push_back(fmt::format("{}: {} cannot be identified", gap.says(), fmt::join(effects, ", ")));
  }
  return said;
}

}  // namespace gustlab
