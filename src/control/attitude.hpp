// Attitudes: from a force and a heading, to Euler angles, and the error between two.
#pragma once

#include <cmath>

#include "gustlab/types.hpp"

namespace gustlab {

// ZYX Euler angles: attitude = Rz(yaw) Ry(pitch) Rx(roll). Positive pitch is nose down.
struct EulerAngles {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double yaw_rad = 0.0;
};

EulerAngles euler_angles(const Quaternion& attitude_WB);
double yaw_of(const Quaternion& attitude_WB);  // rad
Quaternion from_euler(const EulerAngles& angles);
// the same from halves of the angles, for attitudes that share one
struct HalfAngle {
  explicit HalfAngle(double angle_rad) : cosine(std::cos(0.5 * angle_rad)), sine(std::sin(0.5 * angle_rad)) {}
  double cosine, sine;
};
Quaternion from_euler(const HalfAngle& roll, const HalfAngle& pitch, const HalfAngle& yaw);

// The attitude whose z axis points along a force and whose x axis lies in the vertical plane of the heading, which is its
// ZYX yaw. A force shorter than 1e-9 N gives the level attitude.
Quaternion attitude_along(const Vector3& force_W_N, double yaw_rad);

// Keeps the vertical part of a force (at least least_vertical_N) and shortens the horizontal part to a tilt.
Vector3 tilt_limited(const Vector3& force_W_N, double tilt_limit_rad, double least_vertical_N);

// Rotation vector, body axes, that turns an attitude into the desired one; its heading part is weighted, so that the thrust
// direction is put right first (Brescianini & D'Andrea, CEP 77 2018; PX4's AttitudeControl). Length up to π.
Vector3 attitude_error_B_rad(const Quaternion& attitude_WB, const Quaternion& desired_WB, double yaw_weight);

}  // namespace gustlab
