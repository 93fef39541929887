#include "control/attitude.hpp"

#include <algorithm>
#include <cmath>

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
  return Quaternion(Eigen::AngleAxisd(angles.yaw_rad, Vector3::UnitZ()) *
                    Eigen::AngleAxisd(angles.pitch_rad, Vector3::UnitY()) *
                    Eigen::AngleAxisd(angles.roll_rad, Vector3::UnitX()));
}

Quaternion attitude_along(const Vector3& force_W_N, double yaw_rad) {
  const double length = force_W_N.norm();
  const Vector3 z = length < 1e-9 ? Vector3(Vector3::UnitZ()) : Vector3(force_W_N / length);
  const Vector3 across(-std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  Vector3 x = across.cross(z);
  // a force across the heading leaves the pitch open: keep the nose level
  const double nose = x.norm();
  x = nose < 1e-9 ? Vector3(across.y(), -across.x(), 0.0) : Vector3(x / nose);
  Matrix3 R;
  R << x, z.cross(x), z;
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
