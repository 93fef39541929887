// A multirotor as numbers: what MJCF and vehicle.toml say, and what body effects change.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab {

struct Rotor {
  std::string site;                        // the MJCF site that carries it
  Vector3 position_B_m = Vector3::Zero();  // hub, from the body's origin
  Vector3 axis_B = Vector3::UnitZ();       // unit vector along which it pushes
  double direction = 1.0;                  // +1: turns counter-clockwise seen from above
  double thrust_coefficient_Ns2 = 0.0;     // thrust = coefficient Ω², N/(rad/s)²
  double torque_ratio_m = 0.0;             // reaction torque = ratio × thrust
};

inline constexpr double full_pwm = 65535.0;  // u1…uN as pwm: 16 bits, as Crazyflie's firmware has them (FORMATS.md §1)
// Maps other actuator inputs to rotor speed (FORMATS.md §2): Ω = slope u + offset, or f = c0 + c1 u + c2 u² in N.
struct ActuatorMap {
  std::optional<std::pair<double, double>> pwm_line, throttle_line;
  std::optional<std::array<double, 3>> pwm_thrust, throttle_thrust;
};

// One `[[effect]]` table: a type and its parameters, where they were written.
struct EffectSpec {
  std::string type;
  std::vector<std::pair<std::string, std::string>> values;  // key → TOML literal, in order
  std::string where;                                        // file:line:col of the table, for messages
  std::vector<std::string> value_where;                     // of each value; empty: as the table
};

// Surfaces near the flight; what is missing is not assumed.
struct Environment {
  std::optional<double> ground_z_m;
  std::optional<double> ceiling_z_m;
  struct Wall {
    Vector3 point_W_m = Vector3::Zero();
    Vector3 normal_W = Vector3::UnitX();  // unit, horizontal, into the free room
  };
  std::vector<Wall> walls;
};

// A primitive of the MJCF that can touch the ground, in body axes from the body's origin.
struct CollisionShape {
  std::string type;  // MuJoCo's: sphere, capsule, ellipsoid, cylinder, box
  Vector3 size_m = Vector3::Zero();
  Vector3 position_B_m = Vector3::Zero();
  Quaternion attitude_BG = Quaternion::Identity();
};

struct VehicleModel {
  std::string name;
  double mass_kg = 0.0;
  double rated_mass_kg = 0.0;                    // of the vehicle file, which defines hover; 0: mass_kg
  Vector3 center_of_mass_B_m = Vector3::Zero();  // from the body's origin
  Matrix3 inertia_B_kgm2 = Matrix3::Identity();  // about the centre of mass, body axes
  double gravity_mps2 = 9.81;                    // MuJoCo's default
  int rotor_count = 0;
  std::array<Rotor, max_rotors> rotors;
  double max_speed_radps = 0.0;    // infinite: the vehicle file does not say
  double rotor_radius_m = 0.0;     // 0: unknown
  double nominal_voltage_V = 0.0;  // 0: unknown
  bool rotor_speed_known = true;   // false: thrust is known from `hover`, and the scale of speeds is assumed
  bool torque_ratio_known = true;  // false: the rotors' torque ratio is estimated from their size
  ActuatorMap actuator;
  Environment environment;
  std::vector<EffectSpec> effects;     // physics that the nominal vehicle already has
  std::vector<CollisionShape> shapes;  // what touches the ground
  std::string mjcf_path;               // where it was read from, for messages
  std::string source_path;
  std::string source_bytes;  // vehicle.toml and MJCF as read: part of a run's key

  double weight_N() const { return mass_kg * gravity_mps2; }
  // Thrust and speed of one rotor when equal rotors carry the weight that the vehicle file says. A rotor's drag or thrust
  // curve, which refer to hover, do not change when the vehicle is loaded.
  double hover_thrust_N() const { return (rated_mass_kg > 0.0 ? rated_mass_kg : mass_kg) * gravity_mps2 / rotor_count; }
  double hover_speed_radps() const;
  // Mean horizontal distance of the hubs from the centre of mass.
  double arm_m() const;
};

}  // namespace gustlab
