// Discrete low-pass filters of numbers or vectors. A NaN that goes in comes out, and stays.
#pragma once

#include <cmath>
#include <type_traits>

#include "gustlab/types.hpp"

namespace gustlab {

// First order, exact for input held over a period: y += (1 − e^(−T/τ)) (x − y).
template <class Value>
class LowPass1 {
 public:
  LowPass1() = default;
  // time_constant_s 0: no filter
  LowPass1(double time_constant_s, double period_s, const Value& start)
      : gain_(time_constant_s > 0.0 ? 1.0 - std::exp(-period_s / time_constant_s) : 1.0), value_(start) {}

  const Value& update(const Value& input) {
    if (gain_ == 1.0) value_ = input;
    else value_ += gain_ * (input - value_);
    return value_;
  }
  const Value& value() const { return value_; }

 private:
  double gain_ = 1.0;
  Value value_{};
};

inline double time_constant_of(double cutoff_hz) { return cutoff_hz > 0.0 ? 1.0 / (2.0 * pi * cutoff_hz) : 0.0; }

// Second-order Butterworth by the bilinear transform, its cut-off prewarped (Oppenheim & Schafer, ch. 7), direct form II
// transposed. Starts settled at `start`. A cut-off of 0, or at or above half the rate, filters nothing.
template <class Value>
class LowPass2 {
 public:
  LowPass2() = default;
  LowPass2(double cutoff_hz, double period_s, const Value& start) {
    if (cutoff_hz > 0.0 && cutoff_hz * period_s < 0.5) {
      const double k = std::tan(pi * cutoff_hz * period_s);
      const double norm = 1.0 + std::sqrt(2.0) * k + k * k;
      b0_ = k * k / norm;
      a1_ = 2.0 * (k * k - 1.0) / norm;
      a2_ = (1.0 - std::sqrt(2.0) * k + k * k) / norm;
      b1_ = 2.0 * b0_;
      b2_ = b0_;
    }
    value_ = start;
    s1_ = (1.0 - b0_) * start;
    s2_ = (b2_ - a2_) * start;
  }

  const Value& update(const Value& input) {
    if constexpr (std::is_same_v<Value, double>) step(input, value_, s1_, s2_);
    else
      for (int i = 0; i < 3; ++i) step(input[i], value_[i], s1_[i], s2_[i]);
    return value_;
  }
  const Value& value() const { return value_; }

 private:
  void step(double input, double& value, double& s1, double& s2) const {
    value = b0_ * input + s1;
    s1 = b1_ * input - a1_ * value + s2;
    s2 = b2_ * input - a2_ * value;
  }

  double b0_ = 1.0, b1_ = 0.0, b2_ = 0.0, a1_ = 0.0, a2_ = 0.0;
  Value value_{}, s1_{}, s2_{};
};

}  // namespace gustlab
