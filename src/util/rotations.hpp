// Rotation vectors: an axis, as long as the angle about it in radians.
#pragma once

#include <cmath>

#include "gustlab/types.hpp"

namespace gustlab {

// an attitude turned about an axis of the body
inline Quaternion turned(const Quaternion& q, const Vector3& turn_B) {
  const double angle = turn_B.norm();
  return angle > 0.0 ? q * Quaternion(Eigen::AngleAxisd(angle, turn_B / angle)) : q;
}

// rotation vector of a⁻¹ b, in the axes of a
inline Vector3 turn_between(const Quaternion& a, const Quaternion& b) {
  Quaternion d = a.conjugate() * b;
  if (d.w() < 0.0) d.coeffs() *= -1.0;
  const double sine = d.vec().norm();
  return sine > 0.0 ? Vector3(2.0 * std::atan2(sine, d.w()) / sine * d.vec()) : Vector3::Zero();
}

}  // namespace gustlab
