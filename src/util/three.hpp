// Three numbers that stay in registers. Eigen adds its vectors of three two numbers at a time; where each was computed by itself a moment
// before, that load waits until both are stored, which took a fifth of a flight. Sums have Eigen's order, and so its bits.
// At -O2 GCC calls the longer ones, and a call puts its vectors into memory: they are always inlined.
#pragma once

#include <cmath>

#include "gustlab/types.hpp"

namespace gustlab {

#define GUSTLAB_INLINE [[gnu::always_inline]] inline

struct Three {
  double x, y, z;

  Three(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
  Three(const Vector3& v) : x(v[0]), y(v[1]), z(v[2]) {}  // NOLINT: both stand in one formula
  operator Vector3() const { return {x, y, z}; }          // NOLINT: likewise
};

GUSTLAB_INLINE Three operator+(const Three& a, const Three& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
GUSTLAB_INLINE Three operator-(const Three& a, const Three& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
GUSTLAB_INLINE Three operator*(double a, const Three& b) { return {a * b.x, a * b.y, a * b.z}; }
GUSTLAB_INLINE double dot(const Three& a, const Three& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
GUSTLAB_INLINE Three cross(const Three& a, const Three& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
GUSTLAB_INLINE double length(const Three& a) { return std::sqrt(dot(a, a)); }
GUSTLAB_INLINE Three operator/(const Three& a, double b) { return {a.x / b, a.y / b, a.z / b}; }
GUSTLAB_INLINE Three times(const Three& a, const Three& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
// R v and Rᵀ v; Eigen sums the last row of R v from its end
GUSTLAB_INLINE Three rotated(const Matrix3& R, const Three& v) {
  return {(R(0, 0) * v.x + R(0, 1) * v.y) + R(0, 2) * v.z, (R(1, 0) * v.x + R(1, 1) * v.y) + R(1, 2) * v.z,
          R(2, 0) * v.x + (R(2, 1) * v.y + R(2, 2) * v.z)};
}
GUSTLAB_INLINE Three rotated_back(const Matrix3& R, const Three& v) {
  return {dot(Three(R.col(0)), v), dot(Three(R.col(1)), v), dot(Three(R.col(2)), v)};
}
// q v
GUSTLAB_INLINE Three turned(const Quaternion& q, const Three& v) {
  const Three axis(q.x(), q.y(), q.z()), half = cross(axis, v), twice = half + half;
  return (v + q.w() * twice) + cross(axis, twice);
}
// as Quaternion::toRotationMatrix, written where it is wanted
GUSTLAB_INLINE void rotation_of(const Quaternion& q, Matrix3& R) {
  const double tx = 2.0 * q.x(), ty = 2.0 * q.y(), tz = 2.0 * q.z();
  const double twx = tx * q.w(), twy = ty * q.w(), twz = tz * q.w();
  const double txx = tx * q.x(), txy = ty * q.x(), txz = tz * q.x();
  const double tyy = ty * q.y(), tyz = tz * q.y(), tzz = tz * q.z();
  R(0, 0) = 1.0 - (tyy + tzz), R(0, 1) = txy - twz, R(0, 2) = txz + twy;
  R(1, 0) = txy + twz, R(1, 1) = 1.0 - (txx + tzz), R(1, 2) = tyz - twx;
  R(2, 0) = txz - twy, R(2, 1) = tyz + twx, R(2, 2) = 1.0 - (txx + tyy);
}

}  // namespace gustlab
