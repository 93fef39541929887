#include "catalogue.hpp"

#include <stdexcept>

namespace reality {
namespace {

// centre of mass: the torque of 1.2 % of one rotor
constexpr double kComSmall_m = 0.0975e-3, kComLarge_m = 0.77e-3;

std::vector<Effect> build() {
  const double lag = 0.004, delay = 0.003, trim = 0.012, five = 0.05;
  std::vector<Effect> all;
  all.push_back({"rotor_drag", {{"at_hover", {0.015, 0.5}, {0, 0}}}, 8, false});
  all.push_back({"quadratic_drag", {{"area_xy", {0.012, 0.1}, {0, 0}}, {"area_z", {0.012, 0.1}, {0, 0}}}, 8, false});
  all.push_back({"axial_inflow", {{"at_hover", {0.012, 0.8}, {0, 0}}}, 8, false});
  all.push_back({"translational_lift", {{"coefficient", {3e-4, 3e-3}, {0, 0}}}, 12, false});
  all.push_back({"flapping_torque", {{"coefficient", {1e-7, 1.5e-6}, {0, 0}}}, 20, false});
  all.push_back({"ground_effect", {{"strength", {6, 6}, {0, 0}}}, 5, false, Need::ground});
  all.push_back({"ceiling_effect", {{"strength", {6, 6}, {0, 0}}}, 10, false, Need::ceiling});
  all.push_back({"wall_effect", {{"strength", {0.03, 0.03}, {0, 0}}}, 1000, false, Need::wall});
  all.push_back({"steady_wind",
                 {{"x", {0.6, 4}, {0, 0}}, {"y", {0.6, 4}, {0, 0}}, {"z", {0.06, 0.4}, {0, 0}}},
                 2.5,
                 true,
                 Need::drag,
                 false});
  all.push_back({"constant_force",
                 {{"x", {0.01, 0.5}, {0, 0}}, {"y", {0.01, 0.5}, {0, 0}}, {"z", {0.01, 0.5}, {0, 0}}},
                 8,
                 true,
                 Need::nothing,
                 false});
  all.push_back({"mass", {{"delta", {0.05, 0.05}, {trim, trim}}}, 5, true});
  all.push_back({"center_of_mass",
                 {{"x", {1e-3, 8e-3}, {kComSmall_m, kComLarge_m}},
                  {"y", {1e-3, 8e-3}, {kComSmall_m, kComLarge_m}},
                  {"z", {1e-3, 8e-3}, {kComSmall_m, kComLarge_m}}},
                 8,
                 true});
  all.push_back({"inertia",
                 {{"delta_x", {0.1, 0.1}, {five, five}},
                  {"delta_y", {0.1, 0.1}, {five, five}},
                  {"delta_z", {0.1, 0.1}, {five, five}}},
                 5,
                 true});
  all.push_back({"thrust_scale", {{"delta", {0.05, 0.05}, {trim, trim}}}, 5, true});
  all.push_back({"rotor_loss", {{"loss", {0.05, 0.05}, {0.01, 0.01}}}, 5, false});
  all.push_back({"rotor_tilt", {{"x", {0.02, 0.02}, {0, 0}}, {"y", {0.02, 0.02}, {0, 0}}}, 6, true});
  all.push_back({"motor_lag",
                 {{"time_constant", {0.02, 0.01}, {lag, lag}}, {"time_constant_down", {0.02, 0.01}, {lag, lag}}},
                 4,
                 true});
  all.push_back({"actuation_delay", {{"delay", {0.01, 0.006}, {delay, delay}}}, 4, false});
  all.push_back({"thrust_curve", {{"curvature", {0.1, 0.1}, {0, 0}}}, 5, true});
  all.push_back({"saturation", {{"max_speed", {140, 40}, {0, 0}}}, 6, false});
  all.push_back({"battery_sag", {{"exponent", {1, 1}, {0, 0}}, {"rate", {0.004, 0.004}, {0, 0}}}, 3, false});
  all.push_back({"yaw_torque_ratio", {{"delta", {0.15, 0.15}, {five, five}}}, 4, true});
  all.push_back({"rotor_inertia", {{"inertia", {3e-8, 1e-5}, {4.4e-9, 8.3e-6}}}, 10, false});
  all.push_back({"attitude_offset", {{"x", {0.02, 0.02}, {0, 0}}, {"y", {0.02, 0.02}, {0, 0}}}, 6, true});
  all.push_back({"yaw_offset", {{"z", {0.03, 0.03}, {0, 0}}}, 8, true});
  all.push_back({"pose_delay", {{"delay", {0.01, 0.01}, {delay, delay}}}, 4, false});
  all.push_back({"imu_lever",
                 {{"x", {0.01, 0.01}, {0, 0}}, {"y", {0.01, 0.01}, {0, 0}}, {"z", {0.01, 0.01}, {0, 0}}},
                 12,
                 true,
                 Need::accel});
  all.push_back({"gyro_scale", {{"delta", {0.02, 0.02}, {0, 0}}}, 10, true});
  all.push_back({"slung_load", {{"mass", {0.003, 0.2}, {0, 0}}}, 4, false});
  all.push_back(
      {"gust",
       {{"sigma_xy", {0.03, 1}, {0, 0}}, {"sigma_z", {0.03, 1}, {0, 0}}, {"line_amplitude", {0.03, 1}, {0, 0}}},
       6,
       false});
  return all;
}

}  // namespace

const std::vector<Effect>& catalogue() {
  static const std::vector<Effect> all = build();
  return all;
}

const Effect& effect(const std::string& name) {
  for (const Effect& e : catalogue())
    if (e.name == name) return e;
  throw std::invalid_argument("no effect is called '" + name + "'");
}

double nominal_value(const Nominal& n, const std::string& effect, const std::string& parameter) {
  if (effect == "rotor_drag") return n.rotor_drag_at_hover;
  if (effect == "motor_lag") return n.motor_lag_s;
  if (effect == "saturation" && parameter == "max_speed") return n.max_speed_radps;
  return 0;
}

void plant(Truth& t, const std::string& effect, const Values& values) {
  const Nominal& n = t.nominal;
  const auto set = [&](const char* parameter, auto&& assign) {
    if (const auto it = values.find(parameter); it != values.end()) assign(it->second);
  };
  const auto into = [](double& field) { return [&field](double v) { field = v; }; };
  const auto three = [&](Vec3& field) {
    set("x", into(field.x()));
    set("y", into(field.y()));
    set("z", into(field.z()));
  };
  if (effect == "rotor_drag") set("at_hover", into(t.rotor_drag));
  else if (effect == "quadratic_drag") set("area_xy", into(t.area_xy_m2)), set("area_z", into(t.area_z_m2));
  else if (effect == "axial_inflow") set("at_hover", into(t.inflow));
  else if (effect == "translational_lift") set("coefficient", into(t.lift));
  else if (effect == "flapping_torque") set("coefficient", into(t.flapping));
  else if (effect == "ground_effect") set("strength", into(t.ground));
  else if (effect == "ceiling_effect") set("strength", into(t.ceiling));
  else if (effect == "wall_effect") set("strength", into(t.wall));
  else if (effect == "steady_wind") three(t.wind_W_mps);
  else if (effect == "constant_force") three(t.force_W_N);
  else if (effect == "mass") set("delta", [&](double v) { t.mass_kg = n.mass_kg * (1 + v); });
  else if (effect == "center_of_mass") three(t.com_B_m);
  else if (effect == "inertia") {
    set("delta_x", [&](double v) { t.inertia_kgm2.x() = n.inertia_kgm2.x() * (1 + v); });
    set("delta_y", [&](double v) { t.inertia_kgm2.y() = n.inertia_kgm2.y() * (1 + v); });
    set("delta_z", [&](double v) { t.inertia_kgm2.z() = n.inertia_kgm2.z() * (1 + v); });
  } else if (effect == "thrust_scale") set("delta", [&](double v) { t.thrust_scale = 1 + v; });
  else if (effect == "rotor_loss") {
    const auto rotor = static_cast<std::size_t>(values.at("rotor")) - 1;
    t.rotor_gain.at(rotor) = 1 - values.at("loss");
  } else if (effect == "rotor_tilt") three(t.rotor_tilt_rad);
  else if (effect == "motor_lag") set("time_constant", into(t.lag_up_s)), set("time_constant_down", into(t.lag_down_s));
  else if (effect == "actuation_delay") set("delay", into(t.delay_s));
  else if (effect == "thrust_curve") set("curvature", into(t.curvature));
  else if (effect == "saturation") set("max_speed", into(t.max_speed_radps));
  else if (effect == "battery_sag") set("exponent", into(t.sag_exponent)), set("rate", into(t.sag_rate_1ps));
  else if (effect == "yaw_torque_ratio") set("delta", [&](double v) { t.torque_ratio_m = n.torque_ratio_m * (1 + v); });
  else if (effect == "rotor_inertia") set("inertia", into(t.rotor_inertia_kgm2));
  else if (effect == "attitude_offset" || effect == "yaw_offset") three(t.attitude_offset_rad);
  else if (effect == "pose_delay") set("delay", into(t.pose_delay_s));
  else if (effect == "imu_lever") three(t.imu_lever_m);
  else if (effect == "gyro_scale") set("delta", into(t.gyro_scale));
  else if (effect == "slung_load") set("mass", into(t.load_kg)), set("length", into(t.load_length_m));
  else if (effect == "gust") {
    set("sigma_xy", into(t.gust_xy_N)), set("sigma_z", into(t.gust_z_N)), set("correlation_time", into(t.gust_time_s));
    set("line_amplitude", into(t.line_N)), set("line_frequency", into(t.line_radps));
  } else throw std::invalid_argument("no effect is called '" + effect + "'");
}

}  // namespace reality
