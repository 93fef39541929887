#include "control/predictive.hpp"

#include <algorithm>
#include <cmath>

namespace gustlab {

PredictiveAxis::PredictiveAxis(double lag_s, double bandwidth_radps, double damping) : lag_s_(lag_s) {
  const double h = stage_s, z = std::exp(-h / lag_s), slow = lag_s * (1.0 - z), slower = lag_s * (h - slow);
  A_ << 1.0, h, slower, 0.0, 1.0, slow, 0.0, 0.0, z;
  B_ << 0.5 * h * h - slower, h - slow, 1.0 - z;
  const double w2 = bandwidth_radps * bandwidth_radps;
  r_ = 1.0 / (w2 * w2);
  q_ = Vector3(1.0, std::max(0.0, 4.0 * damping * damping - 2.0) / w2, 0.0);

  const Matrix3 Q = q_.asDiagonal();
  P_ = Q;
  for (int i = 0; i < 10000; ++i) {
    K_ = (A_.transpose() * P_ * B_) / (r_ + B_.dot(P_ * B_));
    const Matrix3 next = A_.transpose() * P_ * (A_ - B_ * K_.transpose()) + Q;
    const double change = (next - P_).norm();
    P_ = next;
    if (change < 1e-12 * P_.norm()) break;
  }

  // by the power method; a hundredth on top, as it comes from below. The least curvature is at least that of the inputs.
  Inputs direction, image;
  direction.fill(1.0);
  for (int i = 0; i < 100; ++i) {
    gradient(Vector3::Zero(), direction, image);
    double square = 0.0;
    for (const double value : image) square += value * value;
    curvature_ = std::sqrt(square);
    for (std::size_t k = 0; k < stages; ++k) direction[k] = image[k] / curvature_;
  }
  curvature_ *= 1.01;
  const double root = std::sqrt(2.0 * r_ / curvature_);
  momentum_ = (1.0 - root) / (1.0 + root);
}

void PredictiveAxis::regulate(Vector3 error, Inputs& w) const {
  for (double& input : w) {
    input = -K_.dot(error);
    error = A_ * error + B_ * input;
  }
}

// by the adjoint
void PredictiveAxis::gradient(const Vector3& error, const Inputs& w, Inputs& out) const {
  std::array<Vector3, stages + 1> e;
  e[0] = error;
  for (std::size_t k = 0; k < stages; ++k) e[k + 1] = A_ * e[k] + B_ * w[k];
  Vector3 adjoint = P_ * e[stages];
  for (std::size_t k = stages; k-- > 0;) {
    out[k] = 2.0 * (r_ * w[k] + B_.dot(adjoint));
    adjoint = A_.transpose() * adjoint + q_.cwiseProduct(e[k]);
  }
}

double PredictiveAxis::cost(Vector3 error, const Inputs& w) const {
  double sum = 0.0;
  for (const double input : w) {
    sum += error.dot(q_.cwiseProduct(error)) + r_ * input * input;
    error = A_ * error + B_ * input;
  }
  return sum + error.dot(P_ * error);
}

PredictiveControl::PredictiveControl(const PredictiveAxis& horizontal, const PredictiveAxis& vertical,
                                     const Limits& limits, int iterations)
    : axes_{horizontal, horizontal, vertical}, limits_(limits), iterations_(iterations) {}

const PredictiveControl::Inputs& PredictiveControl::solve(const Matrix3& error, const Inputs& u_ref) {
  constexpr double enough_mps2 = 1e-4;
  for (std::size_t i = 0; i < 3; ++i) axes_[i].regulate(error.row(static_cast<Eigen::Index>(i)), w_[i]);
  if (!limit(w_, u_ref)) return w_;

  Inputs at = w_, next;
  PredictiveAxis::Inputs slope;
  for (int n = 0; n < iterations_; ++n) {
    for (std::size_t i = 0; i < 3; ++i) {
      axes_[i].gradient(error.row(static_cast<Eigen::Index>(i)), at[i], slope);
      for (std::size_t k = 0; k < slope.size(); ++k) next[i][k] = at[i][k] - slope[k] / axes_[i].curvature();
    }
    limit(next, u_ref);
    double change = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < slope.size(); ++k) {
        const double step = next[i][k] - w_[i][k];
        change = std::max(change, std::abs(step));
        at[i][k] = next[i][k] + axes_[i].momentum() * step;
      }
    w_ = next;
    if (change < enough_mps2) break;
  }
  return w_;
}

bool PredictiveControl::limit(Inputs& w, const Inputs& u_ref) const {
  bool moved = false;
  for (std::size_t k = 0; k < w[0].size(); ++k) {
    const double x = u_ref[0][k] + w[0][k], y = u_ref[1][k] + w[1][k], z = u_ref[2][k] + w[2][k];
    if (const double length = std::hypot(x, y); length > limits_.horizontal_mps2) {
      w[0][k] = x * limits_.horizontal_mps2 / length - u_ref[0][k];
      w[1][k] = y * limits_.horizontal_mps2 / length - u_ref[1][k];
      moved = true;
    }
    if (const double within = std::clamp(z, limits_.least_vertical_mps2, limits_.most_vertical_mps2); within != z) {
      w[2][k] = within - u_ref[2][k];
      moved = true;
    }
  }
  return moved;
}

}  // namespace gustlab
