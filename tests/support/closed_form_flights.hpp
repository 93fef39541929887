// Flights whose motion is a formula, with all that a log can hold of them: pose, velocity, inertial data, and the rotor speeds that they need.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

#include "gustlab/flight_log.hpp"
#include "gustlab/random.hpp"
#include "support/vehicles.hpp"

namespace gustlab::test {

using Path = std::function<Vector3(double)>;

inline constexpr double gravity_mps2 = 9.81;

// thrust to weight of five
inline VehicleModel racer() {
  VehicleModel vehicle = ring(4, 0.75, 0.13, 0.0);
  for (Rotor& rotor : vehicle.rotors) rotor.thrust_coefficient_Ns2 *= 2.5;
  return vehicle;
}

inline Vector3 hover(double t) { return {0.05 * std::sin(0.9 * t), 0.04 * std::cos(1.3 * t), 1.0}; }
// 20 m/s around 10.5 m: 38 m/s² to the side
inline Vector3 banked(double t) { return 10.5 * Vector3(std::cos(20.0 / 10.5 * t), std::sin(20.0 / 10.5 * t), 0.0); }
// 12 m/s around 5 m: 3.9 g at the bottom, upside down and 1.9 g at the top
inline Vector3 loop(double t) { return 5.0 * Vector3(std::sin(2.4 * t), 0.0, 1.0 - std::cos(2.4 * t)); }

inline Vector3 acceleration(const Path& path, double t) {
  constexpr double h = 1e-3;
  return (path(t + h) - 2.0 * path(t) + path(t - h)) / (h * h);
}

// the body's z axis along the specific force that the path needs, turned there by the shortest way
inline Quaternion attitude(const Path& path, double t, const Quaternion& near) {
  const Vector3 force = acceleration(path, t) + Vector3(0.0, 0.0, gravity_mps2);
  return (Quaternion::FromTwoVectors(near * Vector3::UnitZ(), force) * near).normalized();
}

inline FlightLog fly(const Path& path, const VehicleModel& vehicle, double step_s = 0.01) {
  constexpr double duration_s = 8.0;
  const RandomStream random(1, 0, "force_checks_test");
  FlightLog log;
  log.path = "somewhere/flight.csv";
  log.meta.hold = Hold::zoh;
  for (const char* name : {"px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz",
                           "wx", "wy", "wz", "ax", "ay", "az", "u1", "u2", "u3", "u4"})
    log.columns.push_back({name, {}});
  double thrust_N2 = 0.0;
  for (const Rotor& rotor : vehicle.rotors) thrust_N2 += rotor.thrust_coefficient_Ns2;
  Quaternion q = attitude(path, 0.0, Quaternion::Identity());
  for (std::uint64_t k = 0; static_cast<double>(k) * step_s < duration_s; ++k) {
    const double t = static_cast<double>(k) * step_s;
    const Quaternion now = attitude(path, t, q), next = attitude(path, t + step_s, now);
    const Vector3 rate = 2.0 / step_s * (now.conjugate() * next).vec();
    const Vector3 velocity = (path(t + 1e-3) - path(t - 1e-3)) / 2e-3,
                  force = now.conjugate() * (acceleration(path, t) + Vector3(0.0, 0.0, gravity_mps2));
    const double speed = std::sqrt(vehicle.mass_kg * force.norm() / thrust_N2);
    const auto noise = [&](std::uint64_t i) { return random.normal4(k, i)[0]; };
    std::uint64_t c = 0;
    const auto put = [&](double value, double sd) { log.columns[c].values.push_back(value + sd * noise(c)), ++c; };
    log.time_s.push_back(t);
    for (int i = 0; i < 3; ++i) put(path(t)[i], 1e-3);
    for (int i = 0; i < 3; ++i) put(velocity[i], 0.01);
    put(now.w(), 1e-4), put(now.x(), 1e-4), put(now.y(), 1e-4), put(now.z(), 1e-4);
    for (int i = 0; i < 3; ++i) put(rate[i], 0.01);
    for (int i = 0; i < 3; ++i) put(force[i], 0.3);
    for (int i = 0; i < 4; ++i) put(speed, 0.01 * speed);
    q = now;
  }
  return log;
}

inline std::vector<double>& column(FlightLog& log, std::string_view name) {
  return std::find_if(log.columns.begin(), log.columns.end(), [&](const LogColumn& c) { return c.name == name; })
      ->values;
}

}  // namespace gustlab::test
