#include "diagnosis/selection/pendulum.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double widest_swing = 0.6;  // rms of the horizontal force over the load's weight
// light loads swing for many periods (aluminium on a thread), hooks that rub and bluff loads for few
constexpr double least_damping = 0.003, most_damping = 0.15;

// lateral pendulum in an accelerated frame: driven part (from rest) and its two free swings, as horizontal force per kg
struct SwingForce {
  std::vector<Eigen::Vector2d> driven;
  std::vector<double> free_position, free_rate;  // alike in x and y
};

SwingForce swing_force(const FlightData& flight, const Swing& swing, double gravity) {
  const std::size_t n = flight.samples.size();
  SwingForce result;
  result.driven.resize(n), result.free_position.resize(n), result.free_rate.resize(n);
  Eigen::Vector2d r = Eigen::Vector2d::Zero(), rate = r;
  Eigen::Vector2d h(1.0, 0.0), dh(0.0, 1.0);  // two free solutions
  const double length_m = swing.length_m, natural = std::sqrt(gravity / length_m),
               damping_ps = 2.0 * swing.damping * natural;
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

// one flight's regression at one swing: load mass, drag, trim per axis, free swing per axis
struct Regression {
  Eigen::MatrixXd X;
  Eigen::VectorXd y;
};
constexpr int shared = 2, own = 6;  // load, drag | trim x y, swing x (2) y (2)

Regression regression(const FlightData& flight, const Smoothed& smoothed, double mass_kg, double gravity,
                      const Swing& swing) {
  const SwingForce s = swing_force(flight, swing, gravity);
  const std::size_t bin = bin_of(flight);
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

// horizontal force of the load, N per axis
double swing_rms(const std::vector<Regression>& flights, const Solution& solution) {
  double sum = 0.0, rows = 0.0;
  for (std::size_t f = 0; f < flights.size(); ++f) {
    const Eigen::MatrixXd& X = flights[f].X;
    const auto free = solution.coefficient.segment<4>(shared + own * static_cast<Eigen::Index>(f) + 2);
    sum += (solution.coefficient[0] * X.col(0) + X.rightCols<4>() * free).squaredNorm();
    rows += static_cast<double>(X.rows());
  }
  return std::sqrt(sum / std::max(1.0, rows));
}

// cable and trim of a flight from the coefficients of its own columns
SwingStart start_of(const Eigen::Matrix<double, own, 1>& c, double load_kg, const Swing& swing, double gravity) {
  const double natural = std::sqrt(gravity / swing.length_m);
  return {Eigen::Vector2d(c[2], c[4]) / load_kg, natural * Eigen::Vector2d(c[3], c[5]) / load_kg, c.head<2>()};
}

std::vector<Regression> regressions(const Session& session, const Swing& swing) {
  std::vector<Regression> flights;
  for (std::size_t f = 0; f < session.flights().size(); ++f)
    flights.push_back(regression(session.flights()[f], session.smoothed[f], session.vehicle().mass_kg,
                                 session.vehicle().gravity_mps2, swing));
  return flights;
}

struct Lengths {
  double shortest_m, longest_m;
};

// The same at any angle, when that leaves less; wide swings take longer than small ones, and hide the length's best value among others. A fit
// that ran out of the lengths that are asked is none: nothing has to stop it at a cable of no length.
PendulumScan swung_out(const Session& session, const PendulumScan& small, double squares, const Lengths& asked) {
  std::vector<const FlightData*> flights;
  std::vector<const Smoothed*> smoothed;
  for (std::size_t f = 0; f < session.flights().size(); ++f) {
    flights.push_back(&session.flights()[f]);
    smoothed.push_back(&session.smoothed[f]);
  }
  constexpr std::array<double, 5> longer = {1.0, 0.92, 1.08, 1.2, 1.35};
  std::array<PendulumScan, longer.size()> swung;
  parallel_for(std::ssize(longer), session.jobs(), [&](std::int64_t i) {
    const auto at = static_cast<std::size_t>(i);
    Swing swing = small.swing;
    swing.length_m *= longer[at];
    const Solution fit = solve_all(regressions(session, swing), true);
    SwingingLoad load{swing, std::max(fit.coefficient[0], 0.5 * small.mass_kg), fit.coefficient[1]};
    std::vector<SwingStart> starts;
    for (std::size_t f = 0; f < flights.size(); ++f)
      starts.push_back(start_of(fit.coefficient.segment<own>(shared + own * static_cast<Eigen::Index>(f)), load.mass_kg,
                                swing, session.vehicle().gravity_mps2));
    const double share =
        1.0 - fit_swing(flights, smoothed, session.vehicle().mass_kg, load, starts, true) / (squares + 1e-300);
    swung[at] = {load.swing, share, load.mass_kg, starts};
  });
  PendulumScan best = small;
  for (const PendulumScan& wide : swung)
    if (wide.share > best.share && wide.swing.length_m >= asked.shortest_m / longer.back() &&
        wide.swing.length_m <= asked.longest_m * longer.back())
      best = wide;
  return best;
}

}  // namespace

PendulumScan scan_pendulum(const Session& session) {
  const VehicleModel& vehicle = session.vehicle();
  const double gravity = vehicle.gravity_mps2;
  PendulumScan best;
  // 0.1–0.65 m for a Crazyflie's arm, in proportion for larger vehicles (DIAGNOSIS.md §3.2)
  const double size = std::clamp(vehicle.arm_m() / 0.04, 1.0, 4.0), shortest_m = 0.10 * size, longest_m = 0.65 * size;
  // without the load, at any swing
  const double squares = solve_all(regressions(session, {shortest_m, least_damping}), false).left;
  const auto better = [&](const std::vector<Swing>& swings) {
    std::vector<PendulumScan> scans(swings.size());
    parallel_for(std::ssize(swings), session.jobs(), [&](std::int64_t i) {
      const auto at = static_cast<std::size_t>(i);
      const Swing& swing = swings[at];
      if (swing.length_m < shortest_m || swing.length_m > longest_m || swing.damping < least_damping ||
          swing.damping > most_damping)
        return;
      const std::vector<Regression> flights = regressions(session, swing);
      const Solution fit = solve_all(flights, true);
      const double load_kg = fit.coefficient[0];
      if (load_kg <= 1e-3 * vehicle.mass_kg || swing_rms(flights, fit) > widest_swing * gravity * load_kg) return;
      scans[at] = {
          {swing.length_m, swing.damping, 0.03 * swing.length_m}, 1.0 - fit.left / (squares + 1e-300), load_kg, {}};
    });
    bool found = false;
    for (std::size_t i = 0; i < scans.size(); ++i)
      if (scans[i].share > best.share) best = scans[i], found = true;
    return found;
  };
  std::vector<Swing> grid;
  for (const double damping : {0.01, 0.05})
    for (double length_m = shortest_m; length_m < longest_m; length_m *= 1.03) grid.push_back({length_m, damping});
  if (!better(grid)) return best;
  // from the best of these uphill, in ever smaller steps
  for (double step = 0.5; step > 0.05;) {
    const Swing from = best.swing;
    std::vector<Swing> near;
    for (const double sign : {-1.0, 1.0}) {
      near.push_back({from.length_m * std::exp(sign * 0.03 * step), from.damping});
      near.push_back({from.length_m, from.damping * std::exp(sign * step)});
    }
    if (!better(near)) step *= 0.5;
  }
  return swung_out(session, best, squares, {shortest_m, longest_m});
}

std::vector<Vector3> pendulum_force(const FlightData& flight, const Smoothed& smoothed, double vehicle_mass_kg,
                                    const Swing& swing, double load_kg) {
  const Regression r = regression(flight, smoothed, vehicle_mass_kg, flight.vehicle.gravity_mps2, swing);
  // the load's mass as it was found on all flights; here only the flight's own
  const Eigen::MatrixXd X = r.X.rightCols<own>();
  const Eigen::VectorXd y = r.y - load_kg * r.X.col(0);
  Eigen::MatrixXd gram = X.transpose() * X;
  gram.diagonal().array() += 1e-9 * gram.diagonal().maxCoeff();
  // where a load swings wide the linear start may lead astray: at rest is another, and a third of the way out to each side
  std::vector<SwingStart> starts{
      start_of(gram.ldlt().solve(X.transpose() * y).tail<own>(), load_kg, swing, flight.vehicle.gravity_mps2), {}};
  for (const Eigen::Vector2d& side :
       {Eigen::Vector2d(0.3, 0.0), Eigen::Vector2d(-0.3, 0.0), Eigen::Vector2d(0.0, 0.3), Eigen::Vector2d(0.0, -0.3)})
    starts.push_back({.cable_W = side});
  std::vector<SwingStart> start(1);
  double least = std::numeric_limits<double>::infinity();
  for (const SwingStart& from : starts) {
    SwingingLoad load{swing, load_kg, 0.0};
    std::vector<SwingStart> fitted{from};
    const double left = fit_swing({&flight}, {&smoothed}, vehicle_mass_kg, load, fitted, false);
    if (left < least) least = left, start = fitted;
  }
  std::vector<Vector3> force = swinging_force(flight, swing, start.front());
  // a load too light for its force whirls out of all bounds
  if (!std::all_of(force.begin(), force.end(), [](const Vector3& f) { return f.allFinite(); }))
    force.assign(force.size(), Vector3::Zero());
  return force;
}

}  // namespace gustlab::diagnosis
