#include "diagnosis/selection/swing_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace gustlab::diagnosis {

namespace {

constexpr double bin_s = 0.1, longest_step_s = 0.012;
constexpr int shared = 4, own = 6;  // log length, log damping, log mass, drag | cable, rate, trim
constexpr int most_steps = 25, most_attempts = 8;
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

// the same on the first part of the flights
double fit_part(const std::vector<const FlightData*>& flights, const std::vector<const Smoothed*>& smoothed,
                double vehicle_mass_kg, SwingingLoad& load, std::vector<SwingStart>& starts, bool load_free,
                double part) {
  const auto count = static_cast<Eigen::Index>(flights.size());
  const Eigen::Index first = load_free ? shared : 0, width = first + own * count;
  const auto force_of = [&](std::size_t f, const Shared& p, const Own& o) {
    return swinging_force(*flights[f], unpack(p).swing, unpack(o), samples_of(*flights[f], part));
  };
  const auto left_of = [&](std::size_t f, const Shared& p, const Own& o, const std::vector<Vector3>& force) {
    return left_over(*flights[f], *smoothed[f], vehicle_mass_kg, unpack(p), unpack(o), force);
  };
  const auto flown = [&](std::size_t f, const Shared& p, const Own& o) { return left_of(f, p, o, force_of(f, p, o)); };
  const auto squares = [&](const Shared& p, const std::vector<Own>& o) {
    double sum = 0.0;
    for (std::size_t f = 0; f < flights.size(); ++f) sum += flown(f, p, o[f]).squaredNorm();
    return sum;
  };
  Shared at = pack(load);
  std::vector<Own> at_own;
  for (const SwingStart& start : starts) at_own.push_back(pack(start));
  double best = squares(at, at_own), damping = 1e-3, rows = 0.0;
  if (!std::isfinite(best)) return best;
  Eigen::MatrixXd normal;
  for (int step = 0; step < most_steps; ++step) {
    normal.setZero(width, width);
    rows = 0.0;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(width);
    for (std::size_t f = 0; f < flights.size(); ++f) {
      const std::vector<Vector3> force = force_of(f, at, at_own[f]);
      const Eigen::VectorXd here = left_of(f, at, at_own[f], force);
      Eigen::MatrixXd J(here.size(), first + own);
      for (Eigen::Index j = 0; j < first + own; ++j) {
        Shared p = at;
        Own o = at_own[f];
        const double delta = 1e-5;
        (j < first ? p[j] : o[j - first]) += delta;
        const bool swings_alike = j < first ? j >= 2 : j >= first + 4;  // mass, drag; trim
        J.col(j) = (here - (swings_alike ? left_of(f, p, o, force) : flown(f, p, o))) / delta;
      }
      const Eigen::Index place = first + own * static_cast<Eigen::Index>(f);
      const Eigen::MatrixXd H = J.transpose() * J;
      const Eigen::VectorXd b = J.transpose() * here;
      normal.topLeftCorner(first, first) += H.topLeftCorner(first, first);
      normal.block(0, place, first, own) = H.topRightCorner(first, own);
      normal.block(place, 0, own, first) = H.bottomLeftCorner(own, first);
      normal.block(place, place, own, own) = H.bottomRightCorner(own, own);
      right.head(first) += b.head(first);
      right.segment(place, own) = b.tail(own);
      rows += static_cast<double>(here.size());
    }
    bool better = false;
    for (int attempt = 0; attempt < most_attempts && !better; ++attempt) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-12 * normal.diagonal().maxCoeff();
      const Eigen::VectorXd move = damped.ldlt().solve(right);
      Shared p = at;
      std::vector<Own> o = at_own;
      p.head(first) += move.head(first);
      for (Eigen::Index f = 0; f < count; ++f) o[static_cast<std::size_t>(f)] += move.segment<own>(first + own * f);
      const double sum = squares(p, o);
      better = std::isfinite(sum) && sum < best;
      damping *= better ? 0.2 : 10.0;
      if (!better) continue;
      const bool settled = sum > best * (1.0 - 1e-5);
      at = p, at_own = o, best = sum;
      if (settled) step = most_steps;
    }
    if (!better) break;
  }
  load = unpack(at);
  if (load_free) {
    const Eigen::VectorXd column = normal.ldlt().solve(Eigen::VectorXd::Unit(width, 0));
    load.swing.length_deviation_m =
        correlated * load.swing.length_m *
        std::sqrt(std::max(0.0, column[0]) * best / std::max(1.0, rows - static_cast<double>(width)));
  }
  for (std::size_t f = 0; f < starts.size(); ++f) starts[f] = unpack(at_own[f]);
  return best;
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
    const double interval_s = flight.samples[k + 1].time_s - flight.samples[k].time_s;
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
