// waypoints: from rest through given points to rest along the curve of least integrated snap squared.
//
// Its solution is a spline of degree 7, six times continuously differentiable (Mellinger & Kumar, ICRA 2011,
// doi 10.1109/ICRA.2011.5980409); the coefficients come from one linear system of all conditions.
#include <Eigen/LU>
#include <algorithm>

#include "gustlab/errors.hpp"
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

constexpr int terms = 8;  // of a polynomial of degree 7

// the k-th derivative of x^j at x
double power_derivative(int j, int k, double x) {
  if (k > j) return 0.0;
  double factor = 1.0;
  for (int i = 0; i < k; ++i) factor *= j - i;
  return factor * std::pow(x, j - k);
}

class Waypoints final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.numbers("points_m", points_W_m_, {.unit = "m", .help = "x, y, z of every point, one after the other"});
    visitor.numbers("times_s", times_s_,
                    {.unit = "s", .help = "when each point is passed, from 0; empty: from the speed"});
    visitor.number("speed_mps", speed_mps_,
                   {.unit = "m/s", .help = "mean speed between points", .min = 1e-3, .max = 100.0});
    visitor.number("yaw_rad", yaw_rad_, {.unit = "rad", .help = "heading", .min = -pi, .max = pi});
  }

  void prepare() override {
    if (points_W_m_.size() % 3 != 0 || points_W_m_.size() < 6 || points_W_m_.size() > 300)
      throw ParameterError("points_m", "points_m must hold x, y, z of 2 to 100 points (three numbers each)");
    const std::size_t count = points_W_m_.size() / 3;
    knots_s_ = times_s_;
    if (knots_s_.empty()) {
      knots_s_.push_back(0.0);
      for (std::size_t i = 1; i < count; ++i)
        knots_s_.push_back(knots_s_.back() + (point(i) - point(i - 1)).norm() / speed_mps_);
    }
    if (knots_s_.size() != count || knots_s_.front() != 0.0)
      throw ParameterError("times_s",
                           "times_s must hold one time per point, the first 0 (a point is passed at a time)");
    for (std::size_t i = 1; i < count; ++i)
      if (!(knots_s_[i] > knots_s_[i - 1]))
        throw ParameterError(times_s_.empty() ? "points_m" : "times_s",
                             "times_s must rise and no two points follow each other at one place");
    solve(static_cast<int>(count) - 1);
  }

  Reference at(double time_s) const override {
    const double time = std::clamp(time_s, 0.0, knots_s_.back());
    const auto later = std::upper_bound(knots_s_.begin() + 1, knots_s_.end() - 1, time);
    const auto segment = static_cast<Eigen::Index>(later - knots_s_.begin()) - 1;
    const double length = knots_s_[static_cast<std::size_t>(segment) + 1] - knots_s_[static_cast<std::size_t>(segment)];
    const bool at_rest = time_s < 0.0 || time_s > knots_s_.back();
    const Jet x =
        (1.0 / length) * ((at_rest ? Jet(time) : Jet::time(time)) - knots_s_[static_cast<std::size_t>(segment)]);
    std::array<Jet, 3> position;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      Jet sum;
      for (Eigen::Index j = terms - 1; j >= 0; --j) sum = sum * x + coefficients_(segment * terms + j, axis);
      position[static_cast<std::size_t>(axis)] = sum;
    }
    return reference_of(position[0], position[1], position[2], yaw_rad_);
  }

  double duration_s() const override { return knots_s_.back(); }

 private:
  Vector3 point(std::size_t i) const { return {points_W_m_[3 * i], points_W_m_[3 * i + 1], points_W_m_[3 * i + 2]}; }

  // each segment is a polynomial of x in [0, 1]
  void solve(int segments) {
    const Eigen::Index size = Eigen::Index{terms} * segments;
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
    Eigen::MatrixX3d right = Eigen::MatrixX3d::Zero(size, 3);
    Eigen::Index row = 0;
    const auto add = [&](int segment, int derivative, double x, double factor) {
      const double length =
          knots_s_[static_cast<std::size_t>(segment) + 1] - knots_s_[static_cast<std::size_t>(segment)];
      for (int j = 0; j < terms; ++j)
        matrix(row, segment * terms + j) += factor * power_derivative(j, derivative, x) / std::pow(length, derivative);
    };
    for (int segment = 0; segment < segments; ++segment) {
      // every segment passes its two points
      for (const int end : {0, 1}) {
        add(segment, 0, end, 1.0);
        right.row(row++) = point(static_cast<std::size_t>(segment + end)).transpose();
      }
      // inner points: derivatives 1 to 6 agree; ends: at rest to jerk
      if (segment + 1 < segments)
        for (int derivative = 1; derivative <= 6; ++derivative, ++row) {
          add(segment, derivative, 1.0, 1.0);
          add(segment + 1, derivative, 0.0, -1.0);
        }
    }
    for (int derivative = 1; derivative <= 3; ++derivative) {
      add(0, derivative, 0.0, 1.0);
      ++row;
      add(segments - 1, derivative, 1.0, 1.0);
      ++row;
    }
    coefficients_ = matrix.fullPivLu().solve(right);
  }

  std::vector<double> points_W_m_{0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.5, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0};
  std::vector<double> times_s_;
  double speed_mps_ = 0.5;
  double yaw_rad_ = 0.0;
  std::vector<double> knots_s_;
  Eigen::MatrixX3d coefficients_;  // 8 per segment, by axis
};

}  // namespace

std::unique_ptr<Trajectory> make_waypoints() { return std::make_unique<Waypoints>(); }

}  // namespace gustlab
