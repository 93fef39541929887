#include "vehicle.hpp"

#include <fstream>
#include <iomanip>
#include <stdexcept>

namespace reality {
namespace {

Nominal small_vehicle() {
  // a Crazyflie 2.x with mocap deck; coefficients of our choice near published identifications
  Nominal n;
  n.name = "reality_cf";
  n.mass_kg = 0.032;
  n.inertia_kgm2 = {16.6e-6, 16.7e-6, 29.3e-6};
  const double arm_m = 0.0325 / std::sqrt(2.0), height_m = 0.006;
  n.hub_B_m = {Vec3(arm_m, -arm_m, height_m), Vec3(-arm_m, -arm_m, height_m), Vec3(-arm_m, arm_m, height_m),
               Vec3(arm_m, arm_m, height_m)};
  n.spin = {1, -1, 1, -1};
  n.thrust_coefficient = 2.0e-8;
  n.torque_ratio_m = 0.0065;
  n.max_speed_radps = 3000;
  n.radius_m = 0.0231;
  n.nominal_voltage_V = 3.8;
  n.motor_lag_s = 0.03;
  return n;
}

Nominal large_vehicle() {
  // the published PX4 Gazebo Iris: mass, inertia, hubs, motor constants
  Nominal n;
  n.name = "reality_ir";
  n.large = true;
  n.mass_kg = 1.535;
  n.inertia_kgm2 = {0.029125, 0.029125, 0.055225};
  n.hub_B_m = {Vec3(0.13, -0.22, 0.023), Vec3(-0.13, 0.20, 0.023), Vec3(0.13, 0.22, 0.023), Vec3(-0.13, -0.20, 0.023)};
  n.spin = {1, 1, -1, -1};
  n.thrust_coefficient = 5.84e-6;
  n.torque_ratio_m = 0.06;
  n.max_speed_radps = 1100;
  n.radius_m = 0.128;
  n.nominal_voltage_V = 11.1;
  n.motor_lag_s = 0.02;
  return n;
}

std::ofstream open(const std::filesystem::path& path) {
  std::ofstream out(path, std::ios::binary);
  if (!out) throw std::runtime_error("cannot write " + path.string());
  return out;
}

}  // namespace

Nominal nominal_vehicle(bool large, bool drag_known) {
  Nominal n = large ? large_vehicle() : small_vehicle();
  if (drag_known) {
    n.name += "_d";
    n.rotor_drag_at_hover = large ? 0.45 : 0.014;
  }
  return n;
}

std::string vehicle_folder(const Nominal& nominal) { return nominal.name; }

void write_vehicle(const Nominal& n, const std::filesystem::path& dir) {
  const std::filesystem::path folder = dir / vehicle_folder(n);
  std::filesystem::create_directories(folder);
  std::ofstream toml = open(folder / "vehicle.toml");
  toml << "# nominal constants of a simulated vehicle: what its maker believes\n"
       << "format = \"gustlab-vehicle/1\"\nname = \"" << n.name << "\"\nmjcf = \"" << n.name << ".xml\"\n";
  for (int i = 0; i < kRotors; ++i)
    toml << "[[rotor]]\nsite = \"rotor" << i + 1 << "\"\ndirection = \"" << (n.spin[i] > 0 ? "ccw" : "cw") << "\"\n";
  toml << "[thrust]\ncoefficient = " << n.thrust_coefficient << "  # N/(rad/s)^2, thrust stand\n"
       << "torque_ratio = " << n.torque_ratio_m << "  # m, thrust stand\n"
       << "max_speed_radps = " << n.max_speed_radps << ".0\nradius_m = " << n.radius_m << "\n"
       << "nominal_voltage_V = " << n.nominal_voltage_V << "\n"
       << "[[effect]]\ntype = \"motor_lag\"\ntime_constant = " << n.motor_lag_s << "  # s, step response\n";
  if (n.rotor_drag_at_hover > 0)
    toml << "[[effect]]\ntype = \"rotor_drag\"\nat_hover = " << n.rotor_drag_at_hover << "  # N s/m, wind tunnel\n";

  std::ofstream xml = open(folder / (n.name + ".xml"));
  xml << std::setprecision(12) << "<mujoco model=\"" << n.name << "\">\n"
      << "  <option gravity=\"0 0 -" << kGravity_mps2 << "\"/>\n  <worldbody>\n"
      << "    <body name=\"" << n.name << "\" pos=\"0 0 1\">\n      <freejoint/>\n      <inertial pos=\"0 0 0\" mass=\""
      << n.mass_kg << "\" diaginertia=\"" << n.inertia_kgm2.x() << ' ' << n.inertia_kgm2.y() << ' '
      << n.inertia_kgm2.z() << "\"/>\n";
  for (int i = 0; i < kRotors; ++i)
    xml << "      <site name=\"rotor" << i + 1 << "\" pos=\"" << n.hub_B_m[i].x() << ' ' << n.hub_B_m[i].y() << ' '
        << n.hub_B_m[i].z() << "\"/>\n";
  xml << "    </body>\n  </worldbody>\n</mujoco>\n";
  if (!toml || !xml) throw std::runtime_error("cannot write under " + folder.string());
}

}  // namespace reality
