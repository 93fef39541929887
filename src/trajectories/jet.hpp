// A number with its first four time derivatives: trajectories are written as formulas of time and come out to snap, exactly.
//
// Coefficients are those of the Taylor series, c[k] = f⁽ᵏ⁾/k!, so that a product is a convolution (Griewank & Walther,
// Evaluating Derivatives, 2nd ed., ch. 13).
#pragma once

#include <cmath>

#include "gustlab/types.hpp"

namespace gustlab {

struct Jet {
  static constexpr int order = 4;
  Eigen::Array<double, order + 1, 1> c = Eigen::Array<double, order + 1, 1>::Zero();

  Jet() = default;
  Jet(double constant) { c[0] = constant; }  // NOLINT: numbers mix with jets in formulas
  static Jet time(double time_s) {
    Jet jet(time_s);
    jet.c[1] = 1.0;
    return jet;
  }

  double value() const { return c[0]; }
  // the k-th derivative, k = 0..4
  double derivative(int k) const {
    constexpr double factorial[order + 1] = {1.0, 1.0, 2.0, 6.0, 24.0};
    return c[k] * factorial[k];
  }
};

inline Jet operator+(Jet a, const Jet& b) {
  a.c += b.c;
  return a;
}

inline Jet operator-(Jet a, const Jet& b) {
  a.c -= b.c;
  return a;
}

inline Jet operator*(const Jet& a, const Jet& b) {
  Jet product;
#pragma GCC unroll 5
  for (int k = 0; k <= Jet::order; ++k)
#pragma GCC unroll 5
    for (int j = 0; j <= k; ++j) product.c[k] += a.c[j] * b.c[k - j];
  return product;
}

inline Jet operator*(double a, Jet b) {
  b.c *= a;
  return b;
}

inline Jet operator/(const Jet& a, const Jet& b) {
  Jet quotient;
  for (int k = 0; k <= Jet::order; ++k) {
    double rest = a.c[k];
    for (int j = 1; j <= k; ++j) rest -= b.c[j] * quotient.c[k - j];
    quotient.c[k] = rest / b.c[0];
  }
  return quotient;
}

struct SineCosine {
  Jet sine, cosine;
};

inline SineCosine sine_cosine(const Jet& angle_rad) {
  SineCosine out{std::sin(angle_rad.c[0]), std::cos(angle_rad.c[0])};
#pragma GCC unroll 5
  for (int k = 1; k <= Jet::order; ++k) {
#pragma GCC unroll 5
    for (int j = 1; j <= k; ++j) {
      const double slope = static_cast<double>(j) * angle_rad.c[j] / static_cast<double>(k);
      out.sine.c[k] += slope * out.cosine.c[k - j];
      out.cosine.c[k] -= slope * out.sine.c[k - j];
    }
  }
  return out;
}

// 0 before time 0, 1 after ramp_s, three times continuously differentiable in between
inline Jet smooth_step(double time_s, double ramp_s) {
  if (time_s <= 0.0 && ramp_s > 0.0) return 0.0;
  if (time_s >= ramp_s) return 1.0;
  const Jet x = (1.0 / ramp_s) * Jet::time(time_s);
  const Jet x2 = x * x;
  return (x2 * x2) * (Jet(35.0) - 84.0 * x + 70.0 * x2 - 20.0 * (x2 * x));
}

// time that starts to run at rest and reaches its full pace after ramp_s: the integral of smooth_step
inline Jet ramped_time(double time_s, double ramp_s) {
  if (time_s >= ramp_s) return Jet::time(time_s - 0.5 * ramp_s);
  if (time_s <= 0.0) return 0.0;
  const Jet x = (1.0 / ramp_s) * Jet::time(time_s);
  const Jet x2 = x * x;
  return ramp_s * ((x2 * x2 * x) * (Jet(7.0) - 14.0 * x + 10.0 * x2 - 2.5 * (x2 * x)));
}

// the reference of three coordinates at a fixed yaw
inline Reference reference_of(const Jet& x, const Jet& y, const Jet& z, double yaw_rad) {
  const auto all = [&](int k) { return Vector3(x.derivative(k), y.derivative(k), z.derivative(k)); };
  Reference reference;
  reference.position_W_m = all(0);
  reference.velocity_W_mps = all(1);
  reference.acceleration_W_mps2 = all(2);
  reference.jerk_W_mps3 = all(3);
  reference.snap_W_mps4 = all(4);
  reference.yaw_rad = yaw_rad;
  return reference;
}

}  // namespace gustlab
