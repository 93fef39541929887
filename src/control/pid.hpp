// Three PIDs side by side, and limits that let a NaN through instead of hiding it.
#pragma once

#include <algorithm>
#include <cmath>

#include "util/three.hpp"

namespace gustlab {

// limit ≥ 0; NaN stays NaN
inline double limited(double value, double limit) { return std::clamp(value, -limit, limit); }

inline Vector3 limited(const Vector3& value, const Vector3& limit) {
  return {limited(value.x(), limit.x()), limited(value.y(), limit.y()), limited(value.z(), limit.z())};
}

// an angle within (−π, π]
// std::remainder is slow, and seldom needed
inline double wrapped(double angle_rad) {
  return std::abs(angle_rad) < pi ? angle_rad : std::remainder(angle_rad, 2.0 * pi);
}

struct PidGains {
  Vector3 p = Vector3::Zero(), i = Vector3::Zero(), d = Vector3::Zero();
  Vector3 integral_limit = Vector3::Constant(1e9);  // of ∫ error dt
};

class Pid {
 public:
  Pid() = default;
  explicit Pid(const PidGains& gains) : gains_(gains) {}

  // derivative: of the error, as the caller filtered it
  Vector3 update(const Vector3& error, const Vector3& derivative, double period_s) {
    const Three sum = integral_ + period_s * Three(error), most = gains_.integral_limit;
    const Three integral(limited(sum.x, most.x), limited(sum.y, most.y), limited(sum.z, most.z));
    integral_ = integral;
    return times(gains_.p, error) + times(gains_.i, integral) + times(gains_.d, derivative);
  }
  const Vector3& integral() const { return integral_; }
  // takes the last step of the integral back, for an output that met its limit
  void hold(const Vector3& integral) { integral_ = integral; }

 private:
  PidGains gains_;
  Vector3 integral_ = Vector3::Zero();
};

// v = P e near zero, and v² = 2 a (|e| − a/2P²) beyond, so that a deceleration a suffices to stop in time
// (the square-root controller of ArduPilot's AP_Math).
inline double square_root_law(double error, double p, double deceleration) {
  const double linear = deceleration / (p * p);
  if (error > linear) return std::sqrt(2.0 * deceleration * (error - 0.5 * linear));
  if (error < -linear) return -std::sqrt(2.0 * deceleration * (-error - 0.5 * linear));
  return p * error;
}

}  // namespace gustlab
