#include "diagnosis/selection/swing_fit.hpp"

#include <ceres/cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/problem.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/estimation/least_squares.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double bin_s = 0.1, longest_step_s = 0.012;
constexpr int shared = 4, own = 6;  // log length, log damping, log mass, drag | cable, rate, trim
constexpr double correlated =
    2.0;  // standard errors of means that depend on their neighbours, over those of independent ones

using Own = Eigen::Matrix<double, own, 1>;
using Shared = Eigen::Matrix<double, shared, 1>;

Shared pack(const SwingingLoad& load) {
  return {std::log(load.swing.length_m), std::log(load.swing.damping), std::log(load.mass_kg), load.drag_kgps};
}
SwingingLoad unpack(const Shared& p) { return {{std::exp(p[0]), std::exp(p[1])}, std::exp(p[2]), p[3]}; }
Own pack(const SwingStart& start) {
  Own p;
  p << start.cable_W, start.rate_W_radps, start.trim_N;
  return p;
}
SwingStart unpack(const Own& p) { return {p.segment<2>(0), p.segment<2>(2), p.segment<2>(4)}; }

// of the first part of a flight, whole bins
std::size_t samples_of(const FlightData& flight, double part) {
  return bin_of(flight) * static_cast<std::size_t>(part * static_cast<double>(flight.samples.size() / bin_of(flight)));
}

// what a load's force leaves of the horizontal disturbance where that force is given, N, as means
Eigen::VectorXd left_over(const FlightData& flight, const Smoothed& smoothed, double mass_kg, const SwingingLoad& load,
                          const SwingStart& start, const std::vector<Vector3>& force) {
  const std::size_t bin = bin_of(flight);
  Eigen::VectorXd left = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(2 * (force.size() / bin)));
  for (std::size_t k = 0; k < force.size(); ++k)
    left.segment<2>(static_cast<Eigen::Index>(2 * (k / bin))) +=
        (mass_kg * smoothed.disturbance[k].head<2>() - load.mass_kg * force[k].head<2>() -
         load.drag_kgps * flight.motion[k].velocity_W_mps.head<2>() - start.trim_N) /
        static_cast<double>(bin);
  return left;
}

// The same on the first part of one flight: residuals in what all swings share and in what is the flight's own.
class FlownSwing final : public ceres::CostFunction {
 public:
  FlownSwing(const FlightData& flight, const Smoothed& smoothed, double vehicle_mass_kg, double part)
      : flight_(flight), smoothed_(smoothed), vehicle_mass_kg_(vehicle_mass_kg), samples_(samples_of(flight, part)) {
    *mutable_parameter_block_sizes() = {shared, own};
    set_num_residuals(static_cast<int>(2 * (samples_ / bin_of(flight))));
  }

  // `jacobians`: forward differences, row-major. False where a residual is not finite.
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Shared at = Eigen::Map<const Shared>(parameters[0]);
    const Own at_own = Eigen::Map<const Own>(parameters[1]);
    const std::vector<Vector3> force = force_of(at, at_own);
    const Eigen::VectorXd here = left_of(at, at_own, force);
    Eigen::Map<Eigen::VectorXd>(residuals, here.size()) = here;
    if (!here.allFinite()) return false;
    if (!jacobians) return true;
    for (int block = 0; block < 2; ++block) {
      if (!jacobians[block]) continue;
      const Eigen::Index columns = block == 0 ? shared : own, linear_from = block == 0 ? 2 : 4;  // mass, drag; trim
      Eigen::Map<RowMajor> J(jacobians[block], here.size(), columns);
      for (Eigen::Index j = 0; j < columns; ++j) {
        Shared p = at;
        Own o = at_own;
        (block == 0 ? p[j] : o[j]) += delta;
        J.col(j) = (left_of(p, o, j >= linear_from ? force : force_of(p, o)) - here) / delta;
      }
      if (!J.allFinite()) return false;
    }
    return true;
  }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static constexpr double delta = 1e-5;

  std::vector<Vector3> force_of(const Shared& p, const Own& o) const {
    return swinging_force(flight_, unpack(p).swing, unpack(o), samples_);
  }
  Eigen::VectorXd left_of(const Shared& p, const Own& o, const std::vector<Vector3>& force) const {
    return left_over(flight_, smoothed_, vehicle_mass_kg_, unpack(p), unpack(o), force);
  }

  const FlightData& flight_;
  const Smoothed& smoothed_;
  const double vehicle_mass_kg_;
  const std::size_t samples_;
};

// of the first unknown, the logarithm of the length, where the residuals are independent and of one variance
double log_length_deviation(ceres::Problem& problem, double squares) {
  ceres::CRSMatrix sparse;
  problem.Evaluate({}, nullptr, nullptr, nullptr, &sparse);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int row = 0; row < sparse.num_rows; ++row)
    for (int i = sparse.rows[static_cast<std::size_t>(row)]; i < sparse.rows[static_cast<std::size_t>(row) + 1]; ++i)
      J(row, sparse.cols[static_cast<std::size_t>(i)]) = sparse.values[static_cast<std::size_t>(i)];
  const Eigen::VectorXd column = (J.transpose() * J).ldlt().solve(Eigen::VectorXd::Unit(J.cols(), 0));
  return std::sqrt(std::max(0.0, column[0]) * squares / std::max(1.0, static_cast<double>(J.rows() - J.cols())));
}

double fit_part(const std::vector<const FlightData*>& flights, const std::vector<const Smoothed*>& smoothed,
                double vehicle_mass_kg, SwingingLoad& load, std::vector<SwingStart>& starts, bool load_free,
                double part) {
  Shared alike = pack(load);
  std::vector<Own> apart;
  for (const SwingStart& start : starts) apart.push_back(pack(start));
  ceres::Problem problem;
  problem.AddParameterBlock(alike.data(), shared);
  if (!load_free) problem.SetParameterBlockConstant(alike.data());
  for (std::size_t f = 0; f < flights.size(); ++f)
    problem.AddResidualBlock(new FlownSwing(*flights[f], *smoothed[f], vehicle_mass_kg, part), nullptr, alike.data(),
                             apart[f].data());
  double half = 0.0;
  if (!problem.Evaluate({}, &half, nullptr, nullptr, nullptr)) return std::numeric_limits<double>::infinity();
  ceres::Solver::Summary summary;
  ceres::Solve(few_unknowns({.damping = 1e-3, .settled = 1e-5, .most_steps = 50}), &problem, &summary);
  const double squares = 2.0 * summary.final_cost;
  load = unpack(alike);
  if (load_free)
    load.swing.length_deviation_m = correlated * load.swing.length_m * log_length_deviation(problem, squares);
  for (std::size_t f = 0; f < starts.size(); ++f) starts[f] = unpack(apart[f]);
  return squares;
}

}  // namespace

std::size_t bin_of(const FlightData& flight) {
  return static_cast<std::size_t>(std::max(1.0, std::round(bin_s / flight.sample_s)));
}

std::vector<Vector3> swinging_force(const FlightData& flight, const Swing& swing, const SwingStart& start,
                                    std::size_t samples) {
  const double gravity = flight.vehicle.gravity_mps2, length_m = swing.length_m;
  const double damping_ps = 2.0 * swing.damping * std::sqrt(gravity / length_m);
  const Eigen::Vector2d level =
      start.cable_W.norm() < 0.98 ? start.cable_W : Eigen::Vector2d(0.98 * start.cable_W.normalized());
  Vector3 n(level.x(), level.y(), -std::sqrt(1.0 - level.squaredNorm()));
  // no faster than a fall from above the vehicle
  const double fastest_radps = 2.0 * std::sqrt(gravity / length_m), rate_radps = start.rate_W_radps.norm();
  const Eigen::Vector2d turning = std::min(1.0, fastest_radps / (rate_radps + 1e-12)) * start.rate_W_radps;
  Vector3 rate(turning.x(), turning.y(), 0.0);
  rate.z() = -rate.head<2>().dot(n.head<2>()) / n.z();  // on the sphere
  std::vector<Vector3> force(std::min(samples, flight.samples.size()));
  for (std::size_t k = 0; k < force.size(); ++k) {
    const Vector3 here = flight.motion[k].acceleration_W_mps2 + gravity * Vector3::UnitZ();
    force[k] = std::max(0.0, length_m * rate.squaredNorm() - here.dot(n)) * n + damping_ps * length_m * rate;
    if (k + 1 == force.size()) break;
    // of the interval, not of its start: half a sample of lag shortens the cable
    const Vector3 q = 0.5 * (here + flight.motion[k + 1].acceleration_W_mps2 + gravity * Vector3::UnitZ());
    const double interval_s = std::min(flight.samples[k + 1].time_s - flight.samples[k].time_s, longest_walk_s);
    const int steps = static_cast<int>(std::ceil(interval_s / longest_step_s));
    for (int i = 0; i < steps; ++i) {
      const double dt = interval_s / steps;
      rate -= dt * ((q - q.dot(n) * n) / length_m + damping_ps * rate);
      // along the great circle, so that no swing gains energy by itself
      const double speed = rate.norm();
      if (speed < 1e-12) continue;
      const Vector3 along = rate / speed, before = n;
      const double c = std::cos(speed * dt), s = std::sin(speed * dt);
      n = before * c + along * s;
      rate = speed * (along * c - before * s);
    }
  }
  return force;
}

double fit_swing(const std::vector<const FlightData*>& flights, const std::vector<const Smoothed*>& smoothed,
                 double vehicle_mass_kg, SwingingLoad& load, std::vector<SwingStart>& starts, bool load_free) {
  // a swing that starts a little wrong is out of step later on
  for (const double part : {0.2, 0.5}) fit_part(flights, smoothed, vehicle_mass_kg, load, starts, load_free, part);
  return fit_part(flights, smoothed, vehicle_mass_kg, load, starts, load_free, 1.0);
}

}  // namespace gustlab::diagnosis
