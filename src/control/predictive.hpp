// A short-sighted optimal control problem on the three axes, with limits: what controller mpc solves at every tick.
//
//   p' = v,  v' = a,  a' = (u − a)/τ      min Σ p² + q v² + r (u − u_ref)²,  u held over each of the stages
// p, v and a are errors, u = u_ref + w is what is asked of the rotors, within |u_xy| ≤ horizontal and least ≤ u_z ≤ most. The cost at the end is
// that of the problem without limits and without an end (Riccati), so that where no limit is met the answer is the linear
// regulator's. Else a fast gradient method with projection finds it (Richter, Jones, Morari, TAC 57(6) 2012).
#pragma once

#include <array>
#include <cstddef>

#include "gustlab/types.hpp"

namespace gustlab {

// One axis without its limits.
class PredictiveAxis {
 public:
  static constexpr std::size_t stages = 20;
  static constexpr double stage_s = 0.05;
  using Inputs = std::array<double, stages>;  // w

  PredictiveAxis() = default;
  // q and r are those by which, without lag, the law is the PD of this bandwidth and damping (at least 0.71)
  PredictiveAxis(double lag_s, double bandwidth_radps, double damping);

  // error: position, velocity, acceleration
  void regulate(Vector3 error, Inputs& w) const;
  void gradient(const Vector3& error, const Inputs& w, Inputs& out) const;
  double cost(Vector3 error, const Inputs& w) const;

  double lag_s() const { return lag_s_; }
  double curvature() const { return curvature_; }  // the largest
  double momentum() const { return momentum_; }

 private:
  double lag_s_ = 0.1, r_ = 1.0, curvature_ = 1.0, momentum_ = 0.0;
  Vector3 q_ = Vector3::Zero(), B_ = Vector3::Zero(), K_ = Vector3::Zero();
  Matrix3 A_ = Matrix3::Identity(), P_ = Matrix3::Zero();
};

class PredictiveControl {
 public:
  using Inputs = std::array<PredictiveAxis::Inputs, 3>;
  struct Limits {
    double horizontal_mps2 = 1.0, least_vertical_mps2 = -1.0, most_vertical_mps2 = 1.0;
  };

  PredictiveControl() = default;
  PredictiveControl(const PredictiveAxis& horizontal, const PredictiveAxis& vertical, const Limits& limits,
                    int iterations);

  // error: a row for each axis. Returns w.
  const Inputs& solve(const Matrix3& error, const Inputs& u_ref);
  const PredictiveAxis& axis(std::size_t i) const { return axes_[i]; }

 private:
  // projects onto the limits; whether anything moved
  bool limit(Inputs& w, const Inputs& u_ref) const;

  std::array<PredictiveAxis, 3> axes_;
  Limits limits_;
  int iterations_ = 50;
  Inputs w_{};
};

}  // namespace gustlab
