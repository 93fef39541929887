#include "diagnosis/pendulum.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace gustlab::diagnosis {

namespace {

constexpr double damping_ps = 0.15;   // of the swing; air drag of a small load

// lateral pendulum in an accelerated frame: driven part (from rest) and its two free swings, as horizontal force per kg
struct Swing {
  std::vector<Eigen::Vector2d> driven;
  std::vector<double> free_position, free_rate;   // alike in x and y
};

Swing swing(const FlightData& flight, double length_m, double gravity) {
  const std::size_t n = flight.samples.size();
  Swing result;
  result.driven.resize(n), result.free_position.resize(n), result.free_rate.resize(n);
  Eigen::Vector2d r = Eigen::Vector2d::Zero(), rate = r;
  Eigen::Vector2d h(1.0, 0.0), dh(0.0, 1.0);   // two free solutions
  const double natural = std::sqrt(gravity / length_m);
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3& a = flight.motion[k].acceleration_W_mps2;
    const double stiffness = (gravity + a.z()) / length_m;
    result.driven[k] = stiffness * r;
    result.free_position[k] = stiffness * h[0] * length_m;
    result.free_rate[k] = stiffness * h[1] * length_m * natural;
    if (k + 1 == n) break;
    const double dt = flight.samples[k + 1].time_s - flight.samples[k].time_s;
    rate += dt * (-stiffness * r - damping_ps * rate - a.head<2>());
    r += dt * rate;
    dh += dt * (-stiffness * h - damping_ps * dh);
    h += dt * dh;
  }
  return result;
}

// one flight's regression at one length: load mass, drag, trim per axis, free swing per axis
struct Regression {
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
};
constexpr int shared = 2, own = 6;   // load, drag | trim x y, swing x (2) y (2)

Regression regression(const FlightData& flight, const Smoothed& smoothed, double mass_kg, double gravity, double length_m) {
  const Swing s = swing(flight, length_m, gravity);
  const auto bin = static_cast<std::size_t>(std::max(1.0, std::round(0.1 / flight.sample_s)));
  const std::size_t bins = flight.samples.size() / bin;
  Regression r;
  r.X.setZero(static_cast<Eigen::Index>(2 * bins), shared + own);
  r.y.setZero(static_cast<Eigen::Index>(2 * bins));
  for (std::size_t b = 0; b < bins; ++b)
    for (std::size_t k = b * bin; k < (b + 1) * bin; ++k)
      for (int axis = 0; axis < 2; ++axis) {
        const auto row = static_cast<Eigen::Index>(2 * b) + axis;
        const double weight = 1.0 / static_cast<double>(bin);
        r.y[row] += weight * mass_kg * smoothed.disturbance[k][axis];
        r.X(row, 0) += weight * s.driven[k][axis];
        r.X(row, 1) += weight * flight.motion[k].velocity_W_mps[axis];
        r.X(row, shared + axis) += weight;
        r.X(row, shared + 2 + 2 * axis) += weight * s.free_position[k];
        r.X(row, shared + 3 + 2 * axis) += weight * s.free_rate[k];
      }
  return r;
}

// least squares over all flights with a light ridge on the free swings; returns coefficients and what is left
struct Solution {
  Eigen::VectorXd coefficient;
  double left = 0.0;
};
Solution solve_all(const std::vector<Regression>& flights, bool with_load) {
  const auto width = static_cast<Eigen::Index>(shared + own * static_cast<int>(flights.size()));
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(width, width);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(width);
  double yy = 0.0;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const Eigen::Index at = shared + own * static_cast<Eigen::Index>(f);
    Eigen::MatrixXd X = flights[f].X;
    if (!with_load) {
      X.col(0).setZero();
      X.rightCols<4>().setZero();
    }
    const Eigen::MatrixXd G = X.transpose() * X;
    const Eigen::VectorXd b = X.transpose() * flights[f].y;
    gram.topLeftCorner<shared, shared>() += G.topLeftCorner<shared, shared>();
    gram.block(at, at, own, own) += G.bottomRightCorner<own, own>();
    gram.block(0, at, shared, own) += G.topRightCorner<shared, own>();
    gram.block(at, 0, own, shared) += G.bottomLeftCorner<own, shared>();
    right.head<shared>() += b.head<shared>();
    right.segment<own>(at) += b.tail<own>();
    yy += flights[f].y.squaredNorm();
  }
  gram.diagonal().array() += 1e-9 * gram.diagonal().maxCoeff();
  Solution s;
  s.coefficient = gram.ldlt().solve(right);
  s.left = yy - 2.0 * right.dot(s.coefficient) + s.coefficient.dot(gram * s.coefficient);
  return s;
}

}  // namespace

PendulumScan scan_pendulum(const Session& session) {
  const VehicleModel& vehicle = session.vehicle();
  const double gravity = vehicle.gravity_mps2;
  PendulumScan best;
  // 0.1–0.65 m for a Crazyflie's arm, in proportion for larger vehicles (DIAGNOSIS.md §3.2)
  const double size = std::clamp(vehicle.arm_m() / 0.04, 1.0, 4.0);
  for (double log_length = std::log(0.10 * size); log_length < std::log(0.65 * size); log_length += 0.03) {
    std::vector<Regression> flights;
    for (std::size_t f = 0; f < session.flights().size(); ++f)
      flights.push_back(regression(session.flights()[f], session.smoothed[f], vehicle.mass_kg, gravity, std::exp(log_length)));
    const Solution with = solve_all(flights, true), without = solve_all(flights, false);
    const double share = 1.0 - with.left / (without.left + 1e-300);
    if (with.coefficient[0] > 1e-3 * vehicle.mass_kg && share > best.share)
      best = {std::exp(log_length), share, with.coefficient[0]};
  }
  return best;
}

std::vector<Vector3> pendulum_force(const FlightData& flight, const Smoothed& smoothed, double vehicle_mass_kg,
                                    const PendulumScan& scan) {
  const double gravity = flight.vehicle.gravity_mps2;
  const Swing s = swing(flight, scan.length_m, gravity);
  const Regression r = regression(flight, smoothed, vehicle_mass_kg, gravity, scan.length_m);
  // the load's mass as it was found on all flights; here only the free swing
  Eigen::MatrixXd X = r.X.rightCols<5 + shared - 1>();
  const Eigen::VectorXd y = r.y - scan.mass_kg * r.X.col(0);
  Eigen::MatrixXd gram = X.transpose() * X;
  gram.diagonal().array() += 1e-9 * gram.diagonal().maxCoeff();
  const Eigen::VectorXd c = gram.ldlt().solve(X.transpose() * y);
  std::vector<Vector3> force(flight.samples.size());
  for (std::size_t k = 0; k < force.size(); ++k) {
    for (int axis = 0; axis < 2; ++axis)
      force[k][axis] = s.driven[k][axis] + (c[2 + 2 * axis] * s.free_position[k] + c[3 + 2 * axis] * s.free_rate[k]) / scan.mass_kg;
    force[k].z() = -(gravity + flight.motion[k].acceleration_W_mps2.z());
  }
  return force;
}

}  // namespace gustlab::diagnosis
