#include "control/attitude.hpp"

#include <algorithm>
#include <cmath>

#include "util/three.hpp"

namespace gustlab {

namespace {

// rotation vector of a unit quaternion, the short way round
Vector3 rotation_vector(const Quaternion& q) {
  const double sine = q.vec().norm();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  if (sine < 1e-9) return 2.0 * sign * q.vec();
  return (sign * 2.0 * std::atan2(sine, std::abs(q.w())) / sine) * q.vec();
}

}  // namespace

EulerAngles euler_angles(const Quaternion& q) {
  return {std::atan2(2.0 * (q.w() * q.x() + q.y() * q.z()), 1.0 - 2.0 * (q.x() * q.x() + q.y() * q.y())),
          std::asin(std::clamp(2.0 * (q.w() * q.y() - q.z() * q.x()), -1.0, 1.0)), yaw_of(q)};
}

double yaw_of(const Quaternion& q) {
  return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()), 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()));
}

Quaternion from_euler(const EulerAngles& angles) {
  return from_euler(HalfAngle(angles.roll_rad), HalfAngle(angles.pitch_rad), HalfAngle(angles.yaw_rad));
}

Quaternion from_euler(const HalfAngle& roll, const HalfAngle& pitch, const HalfAngle& yaw) {
  const auto [cr, sr] = roll;
  const auto [cp, sp] = pitch;
  const auto [cy, sy] = yaw;
  // turns about z and y, and then about x
  const double w = cy * cp, x = sy * sp, y = cy * sp, z = sy * cp;
  return Quaternion(w * cr + x * sr, w * sr - x * cr, y * cr + z * sr, z * cr - y * sr);
}

Quaternion attitude_along(const Vector3& force_W_N, double yaw_rad) {
  const Three force = force_W_N;
  const double most = length(force);
  const Three z = most < 1e-9 ? Three(0.0, 0.0, 1.0) : force / most;
  const Three across(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  Three x = cross(across, z);
  // a force across the heading leaves the pitch open: keep the nose level
  const double nose = length(x);
  x = nose < 1e-9 ? Three(across.y, -across.x, 0.0) : x / nose;
  const Three y = cross(z, x);
  Matrix3 R;
  R(0, 0) = x.x, R(0, 1) = y.x, R(0, 2) = z.x;
  R(1, 0) = x.y, R(1, 1) = y.y, R(1, 2) = z.y;
  R(2, 0) = x.z, R(2, 1) = y.z, R(2, 2) = z.z;
  return Quaternion(R);
}

Vector3 tilt_limited(const Vector3& force_W_N, double tilt_limit_rad, double least_vertical_N) {
  Vector3 force = force_W_N;
  if (force.z() < least_vertical_N) force.z() = least_vertical_N;
  const double most = force.z() * std::tan(tilt_limit_rad);
  const double horizontal = force.head<2>().norm();
  if (horizontal > most) force.head<2>() *= most / horizontal;
  return force;
}

Vector3 attitude_error_B_rad(const Quaternion& attitude_WB, const Quaternion& desired_WB, double yaw_weight) {
  const Quaternion error = attitude_WB.conjugate() * desired_WB;
  // error = tilt · turn, turn about z: the smallest rotation that puts the thrust direction right comes first
  const double c = std::sqrt(error.w() * error.w() + error.z() * error.z());
  if (c < 1e-9) return rotation_vector(error);
  const Quaternion turn(error.w() / c, 0.0, 0.0, error.z() / c);
  return rotation_vector(error * turn.conjugate()) + yaw_weight * rotation_vector(turn);
}

}  // namespace gustlab
