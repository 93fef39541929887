// Vehicles as code, for tests that must not depend on files.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gustlab/vehicle.hpp"

namespace gustlab::test {

inline Rotor rotor(double x_m, double y_m, double z_m, double direction, double coefficient_Ns2, double ratio_m) {
  Rotor out;
  out.position_B_m = {x_m, y_m, z_m};
  out.direction = direction;
  out.thrust_coefficient_Ns2 = coefficient_Ns2;
  out.torque_ratio_m = ratio_m;
  return out;
}

inline EffectSpec effect(std::string type, std::vector<std::pair<std::string, std::string>> values) {
  EffectSpec spec;
  spec.type = std::move(type);
  spec.values = std::move(values);
  return spec;
}

// CrazySim's plant (arXiv 2603.08863)
inline VehicleModel crazyflie() {
  VehicleModel vehicle;
  vehicle.name = "crazyflie";
  vehicle.mass_kg = 0.0282;
  vehicle.inertia_B_kgm2 = Vector3(2.09e-5, 2.10e-5, 3.54e-5).asDiagonal();
  vehicle.rotor_count = 4;
  const double k = 1.7965e-8, ratio = 0.005964552;
  vehicle.rotors[0] = rotor(0.031, -0.031, 0.021, 1.0, k, ratio);
  vehicle.rotors[1] = rotor(-0.031, -0.031, 0.021, -1.0, k, ratio);
  vehicle.rotors[2] = rotor(-0.031, 0.031, 0.021, 1.0, k, ratio);
  vehicle.rotors[3] = rotor(0.031, 0.031, 0.021, -1.0, k, ratio);
  vehicle.max_speed_radps = 3052.0;
  vehicle.rotor_radius_m = 0.0231;
  vehicle.actuator.pwm_line = {0.04076521, 380.8359};
  vehicle.effects = {effect("motor_lag", {{"time_constant", "0.0125"}, {"time_constant_down", "0.025"}}),
                     effect("rotor_drag", {{"at_hover", "0.0072"}})};
  return vehicle;
}

// ArduPilot's Gazebo Iris with its gimbal
inline VehicleModel iris() {
  VehicleModel vehicle;
  vehicle.name = "iris";
  vehicle.mass_kg = 1.98;
  vehicle.inertia_B_kgm2 = Vector3(0.0163, 0.0205, 0.0238).asDiagonal();
  vehicle.rotor_count = 4;
  const double k = 2.1665e-5, ratio = 0.00198;
  vehicle.rotors[0] = rotor(0.13, -0.22, 0.023, 1.0, k, ratio);
  vehicle.rotors[1] = rotor(-0.13, 0.20, 0.023, 1.0, k, ratio);
  vehicle.rotors[2] = rotor(0.13, 0.22, 0.023, -1.0, k, ratio);
  vehicle.rotors[3] = rotor(-0.13, -0.20, 0.023, -1.0, k, ratio);
  vehicle.max_speed_radps = 620.9;
  vehicle.actuator.pwm_line = {838.0 / 65535.0, 0.0};
  vehicle.rotor_radius_m = 0.1;
  return vehicle;
}

// 4 to 8 rotors evenly on a circle, alternating. Three cannot control yaw: they turn the same way, each tilted so that its
// thrust makes up for its reaction torque
inline VehicleModel ring(int count, double mass_kg, double arm_m, double lag_s) {
  VehicleModel vehicle;
  vehicle.name = "ring" + std::to_string(count);
  vehicle.mass_kg = mass_kg;
  vehicle.inertia_B_kgm2 = (Vector3(1.0, 1.0, 1.8) * 0.25 * mass_kg * arm_m * arm_m).asDiagonal();
  vehicle.rotor_count = count;
  vehicle.max_speed_radps = 1000.0;
  // thrust to weight of 2
  const double k = 2.0 * mass_kg * 9.81 / count / 1e6;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * pi * (i + 0.5) / count;
    vehicle.rotors[static_cast<std::size_t>(i)] =
        rotor(arm_m * std::cos(angle), arm_m * std::sin(angle), 0.0, i % 2 && count > 3 ? -1.0 : 1.0, k, 0.3 * arm_m);
    if (count == 3)
      vehicle.rotors[static_cast<std::size_t>(i)].axis_B =
          Vector3(-0.3 * std::sin(angle), 0.3 * std::cos(angle), 1.0).normalized();
  }
  vehicle.rotor_radius_m = 0.4 * arm_m;
  vehicle.effects = {effect("motor_lag", {{"time_constant", std::to_string(lag_s)}})};
  return vehicle;
}

}  // namespace gustlab::test
