// The vocabulary of a flight: states, observations, references and commands.
//
// Frames: W is the world, z up; B is the body, x forward, y left, z up. Attitudes are Hamilton quaternions body → world.
// A name says its frame and its unit: body_rate_B_radps.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace gustlab {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

inline constexpr int max_rotors = 8;
// one value per rotor, in the vehicle file's order; entries past the rotor count are zero
using RotorArray = std::array<double, max_rotors>;

// standard air at sea level, kg/m³ (ISO 2533:1975)
inline constexpr double air_density_kgpm3 = 1.225;
inline constexpr double pi = 3.14159265358979323846;

// The truth about the vehicle. Position and velocity are of the MJCF body's origin.
struct VehicleState {
  double time_s = 0.0;
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  Quaternion attitude_WB = Quaternion::Identity();
  Vector3 body_rate_B_radps = Vector3::Zero();
  RotorArray rotor_speed_radps{};
};

// What a controller may see. A separate type, so that no controller can read the truth or the gust.
struct Observation {
  double time_s = 0.0;       // of the control tick
  double pose_time_s = 0.0;  // when pose and velocity were true
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  Quaternion attitude_WB = Quaternion::Identity();
  double inertial_time_s = 0.0;  // when the inertial data were true
  Vector3 body_rate_B_radps = Vector3::Zero();
  Vector3 specific_force_B_mps2 = Vector3::Zero();  // accelerometer: +9.81 in z when hovering
  RotorArray rotor_speed_radps{};
  double voltage_V = 0.0;  // 0: not measured
};

// Where the vehicle should be at a time, to the fourth derivative.
struct Reference {
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  Vector3 acceleration_W_mps2 = Vector3::Zero();
  Vector3 jerk_W_mps3 = Vector3::Zero();
  Vector3 snap_W_mps4 = Vector3::Zero();
  double yaw_rad = 0.0;
  double yaw_rate_radps = 0.0;
};

// The common currency of controllers and plants: the rotor speeds that are asked for.
struct RotorCommand {
  RotorArray speed_radps{};
};

// A force and a torque about the centre of mass, both in body axes.
struct Wrench {
  Vector3 force_B_N = Vector3::Zero();
  Vector3 torque_B_Nm = Vector3::Zero();
};

}  // namespace gustlab
