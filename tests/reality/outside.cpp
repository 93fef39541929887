#include "outside.hpp"

#include <stdexcept>

namespace reality {

const std::vector<std::string>& strangers() {
  static const std::vector<std::string> all{"sticking_esc",     "fan_jet",     "climb_drag",
                                            "swinging_payload", "vortex_ring", "dropouts",
                                            "torque_trim",      "cross_force", "tether"};
  return all;
}

Stranger draw_stranger(const std::string& name, const Nominal& n, double size, Rng& rng) {
  const bool large = n.large;
  const double span_m = large ? 6.5 : 1.4, newton = n.mass_kg * size, side = rng.sign();
  const double heading = rng.uniform(0, 2 * std::numbers::pi);
  const Vec3 level(std::cos(heading), std::sin(heading), 0);
  Stranger s;
  s.name = name;
  Outside& o = s.physics;
  if (name == "sticking_esc") {
    o.esc_stick_radps = size * (large ? 18 : 45) * rng.uniform(0.8, 1.2);
    s.channels = {"actuation", "force_z", "torque_x", "torque_y", "torque_z"};
  } else if (name == "fan_jet") {
    const double where = rng.uniform(0, 2 * std::numbers::pi);
    o.jet_center_W_m = 0.5 * span_m * Vec3(std::cos(where), std::sin(where), 0);
    o.jet_radius_m = span_m * rng.uniform(0.2, 0.35);
    o.jet_force_W_N = newton * (1.2 * level + Vec3(0, 0, rng.uniform(-0.2, 0.2)));
    s.channels = {"force_x", "force_y"};
  } else if (name == "climb_drag") {
    o.climb_drag = newton * (large ? 0.9 : 2.5) * rng.uniform(0.8, 1.2);
    s.channels = {"force_z"};
  } else if (name == "swinging_payload") {
    o.payload_kg = n.mass_kg * std::min(0.3, 0.07 * size);
    o.payload_arm_m = large ? 0.15 : 0.03;
    o.payload_hz = rng.uniform(2.5, 5.0);
    o.payload_friction_N = o.payload_kg * rng.uniform(0.05, 0.2);
    s.channels = {"force_x", "force_y", "torque_x", "torque_y"};
  } else if (name == "vortex_ring") {
    o.vortex_loss = std::min(0.5, 0.15 * size);
    o.vortex_speed_mps = (large ? 1.2 : 0.5) * rng.uniform(0.8, 1.2);
    s.channels = {"force_z"};
  } else if (name == "dropouts") {
    o.dropout_rotor = rng.below(kRotors);
    o.dropout_loss = std::min(0.5, 0.12 * size);
    s.channels = {"force_z", "torque_x", "torque_y", "torque_z", "actuation"};
  } else if (name == "torque_trim") {
    o.trim_axis_B = level;
    o.trim_Nm = side * size * n.inertia_kgm2.x() * (large ? 0.6 : 4.0);
    o.trim_period_s = rng.uniform(5, 12);
    s.channels = {"torque_x", "torque_y"};
  } else if (name == "cross_force") {
    o.cross_force = side * newton * (large ? 0.15 : 0.4);
    s.channels = {"force_x", "force_y"};
  } else if (name == "tether") {
    o.tether_W_m = 0.6 * span_m * level;
    o.tether_slack_m = 0.4 * span_m;
    o.tether_npm = newton * (large ? 0.2 : 0.9);
    s.channels = {"force_x", "force_y", "force_z"};
  } else {
    throw std::invalid_argument("no physics outside the catalogue is called '" + name + "'");
  }
  return s;
}

}  // namespace reality
