// everything that the real vehicle and its surroundings are
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>

#include "rng.hpp"

namespace reality {

constexpr int kRotors = 4;
using PerRotor = std::array<double, kRotors>;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

constexpr double kGravity_mps2 = 9.81;       // both vehicle files say so
constexpr double kAirDensity_kgpm3 = 1.225;  // ISA at sea level

/// Vertical plane through `point_W_m` whose horizontal unit `normal_W` points into free space.
struct Wall {
  Eigen::Vector2d point_W_m;
  Eigen::Vector2d normal_W;
};

/// what the log's sidecar knows of the surroundings
struct Surroundings {
  std::optional<double> ground_z_m;
  std::optional<double> ceiling_z_m;
  std::optional<Wall> wall;
};

/// Constants of the vehicle file that the diagnosis is given.
struct Nominal {
  std::string name;
  bool large = false;  // Iris size
  double mass_kg = 0;
  Vec3 inertia_kgm2 = Vec3::Zero();
  std::array<Vec3, kRotors> hub_B_m;  // from the body origin, which is the nominal centre of mass
  PerRotor spin{};                    // +1 ccw seen from above
  double thrust_coefficient = 0;      // N/(rad/s)^2
  double torque_ratio_m = 0;
  double max_speed_radps = 0;
  double radius_m = 0;
  double nominal_voltage_V = 0;
  double motor_lag_s = 0;
  double rotor_drag_at_hover = 0;  // N s/m; zero in the plain vehicle files
  double hover_thrust_N() const { return mass_kg * kGravity_mps2 / kRotors; }
  double hover_speed_radps() const { return std::sqrt(hover_thrust_N() / thrust_coefficient); }
};

/// Physics outside the catalogue; all zero unless a trial is drawn as `outside`.
struct Outside {
  double esc_stick_radps = 0;  // a speed controller ignores changes of its command below this
  Vec3 jet_center_W_m = Vec3::Zero();
  Vec3 jet_force_W_N = Vec3::Zero();
  double jet_radius_m = 1;
  double climb_drag = 0;        // N s^2/m^2, only while climbing
  double vortex_loss = 0;       // share of thrust lost in the middle of the vortex ring state
  double vortex_speed_mps = 1;  // descent speed where it is worst
  int dropout_rotor = -1;
  double dropout_loss = 0;
  double trim_Nm = 0;  // slowly wandering torque, worst axis
  double trim_period_s = 20;
  Vec3 trim_axis_B = Vec3::UnitX();
  double cross_force = 0;  // N s/m, horizontal force across the velocity
  double tether_npm = 0;   // N/m toward tether_W_m beyond its slack length
  Vec3 tether_W_m = Vec3::Zero();
  double tether_slack_m = 0;
  double payload_kg = 0;  // on a bending stem below the body, with dry friction
  double payload_arm_m = 0;
  double payload_hz = 2;
  double payload_friction_N = 0;
};

/// The vehicle that flies. Values are totals, in the units of the catalogue.
struct Truth {
  Nominal nominal;
  double mass_kg = 0;
  Vec3 inertia_kgm2 = Vec3::Zero();
  Vec3 com_B_m = Vec3::Zero();  // from the body origin
  double thrust_scale = 1;
  PerRotor rotor_gain{1, 1, 1, 1};
  double torque_ratio_m = 0;
  Vec3 rotor_tilt_rad = Vec3::Zero();  // x, y used
  double curvature = 0;
  double sag_exponent = 0;
  double sag_rate_1ps = 0;
  double rotor_inertia_kgm2 = 0;
  double lag_up_s = 0, lag_down_s = 0, delay_s = 0;
  double max_speed_radps = 0;
  double rotor_drag = 0, area_xy_m2 = 0, area_z_m2 = 0, inflow = 0, lift = 0, flapping = 0;
  double ground = 0, ceiling = 0, wall = 0;
  Vec3 wind_W_mps = Vec3::Zero();
  Vec3 force_W_N = Vec3::Zero();
  double gust_xy_N = 0, gust_z_N = 0, gust_time_s = 1, line_N = 0, line_radps = 1;
  double load_kg = 0, load_length_m = 0.3;
  double hook_damping = 0.03;  // damping ratio of a swinging load: the hook rubs, so that a swing dies out in seconds
  Vec3 attitude_offset_rad = Vec3::Zero();
  double pose_delay_s = 0;
  Vec3 imu_lever_m = Vec3::Zero();
  double gyro_scale = 0;
  Surroundings surroundings;
  Outside outside;
};

/// A vehicle exactly as its file says.
Truth as_nominal(const Nominal& nominal);

/// Rotation of angle |v| about v.
inline Quat rotation(const Vec3& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Quat(1, 0.5 * v.x(), 0.5 * v.y(), 0.5 * v.z()).normalized();
  return Quat(Eigen::AngleAxisd(angle, v / angle));
}

}  // namespace reality
