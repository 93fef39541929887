#include "diagnosis/selection/swing_fit.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimation/levenberg_marquardt.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double bin_s = 0.1, longest_step_s = 0.012;
constexpr int shared = 4, own = 6;  // log length, log damping, log mass, drag | cable, rate, trim
constexpr Marquardt marquardt{.damping = 1e-3, .harder = 10.0, .settled = 1e-5, .most_steps = 25, .most_attempts = 8};
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

// The same on the first part of the flights, as least squares in what all swings share (when the load is free) and in every flight's own.
class SwingProblem {
 public:
  SwingProblem(const std::vector<const FlightData*>& flights, const std::vector<const Smoothed*>& smoothed,
               double vehicle_mass_kg, const SwingingLoad& load, bool load_free, double part)
      : flights_(flights),
        smoothed_(smoothed),
        vehicle_mass_kg_(vehicle_mass_kg),
        load_(pack(load)),
        first_(load_free ? shared : 0),
        part_(part) {}

  using Equations = NormalEquations<Eigen::MatrixXd, Eigen::VectorXd>;

  Eigen::VectorXd packed(const std::vector<SwingStart>& starts) const {
    Eigen::VectorXd x(first_ + own * std::ssize(starts));
    x.head(first_) = load_.head(first_);
    for (std::size_t f = 0; f < starts.size(); ++f) x.segment<own>(place(f)) = pack(starts[f]);
    return x;
  }
  Shared load(const Eigen::VectorXd& x) const {
    Shared p = load_;
    p.head(first_) = x.head(first_);
    return p;
  }
  Own start(const Eigen::VectorXd& x, std::size_t f) const { return x.segment<own>(place(f)); }

  double squares(const Eigen::VectorXd& x) const {
    double sum = 0.0;
    for (std::size_t f = 0; f < flights_.size(); ++f) sum += flown(f, load(x), start(x, f)).squaredNorm();
    return sum;
  }

  Equations linearise(const Eigen::VectorXd& x) {
    Equations all{Eigen::MatrixXd::Zero(x.size(), x.size()), Eigen::VectorXd::Zero(x.size())};
    rows_ = 0.0;
    for (std::size_t f = 0; f < flights_.size(); ++f) {
      const Shared at = load(x);
      const Own at_own = start(x, f);
      const std::vector<Vector3> force = force_of(f, at, at_own);
      const Eigen::VectorXd here = left_of(f, at, at_own, force);
      Eigen::MatrixXd J(here.size(), first_ + own);
      for (Eigen::Index j = 0; j < first_ + own; ++j) {
        Shared p = at;
        Own o = at_own;
        const double delta = 1e-5;
        (j < first_ ? p[j] : o[j - first_]) += delta;
        const bool swings_alike = j < first_ ? j >= 2 : j >= first_ + 4;  // mass, drag; trim
        J.col(j) = (here - (swings_alike ? left_of(f, p, o, force) : flown(f, p, o))) / delta;
      }
      const Eigen::MatrixXd H = J.transpose() * J;
      const Eigen::VectorXd b = J.transpose() * here;
      all.normal.topLeftCorner(first_, first_) += H.topLeftCorner(first_, first_);
      all.normal.block(0, place(f), first_, own) = H.topRightCorner(first_, own);
      all.normal.block(place(f), 0, own, first_) = H.bottomLeftCorner(own, first_);
      all.normal.block(place(f), place(f), own, own) = H.bottomRightCorner(own, own);
      all.right.head(first_) += b.head(first_);
      all.right.segment(place(f), own) = b.tail(own);
      rows_ += static_cast<double>(here.size());
    }
    return all;
  }
  double rows() const { return rows_; }

 private:
  Eigen::Index place(std::size_t f) const { return first_ + own * static_cast<Eigen::Index>(f); }
  std::vector<Vector3> force_of(std::size_t f, const Shared& p, const Own& o) const {
    return swinging_force(*flights_[f], unpack(p).swing, unpack(o), samples_of(*flights_[f], part_));
  }
  Eigen::VectorXd left_of(std::size_t f, const Shared& p, const Own& o, const std::vector<Vector3>& force) const {
    return left_over(*flights_[f], *smoothed_[f], vehicle_mass_kg_, unpack(p), unpack(o), force);
  }
  Eigen::VectorXd flown(std::size_t f, const Shared& p, const Own& o) const {
    return left_of(f, p, o, force_of(f, p, o));
  }

  const std::vector<const FlightData*>& flights_;
  const std::vector<const Smoothed*>& smoothed_;
  const double vehicle_mass_kg_;
  const Shared load_;
  const Eigen::Index first_;
  const double part_;
  double rows_ = 0.0;  // residuals
};

double fit_part(const std::vector<const FlightData*>& flights, const std::vector<const Smoothed*>& smoothed,
                double vehicle_mass_kg, SwingingLoad& load, std::vector<SwingStart>& starts, bool load_free,
                double part) {
  SwingProblem problem(flights, smoothed, vehicle_mass_kg, load, load_free, part);
  Eigen::VectorXd x = problem.packed(starts);
  double best = problem.squares(x);
  if (!std::isfinite(best)) return best;
  SwingProblem::Equations last;
  best = minimise(
      x, best, marquardt, [&](const auto& at) { return problem.linearise(at); },
      [&](const auto& at) { return problem.squares(at); }, last);
  load = unpack(problem.load(x));
  if (load_free) {
    const Eigen::VectorXd column = last.normal.ldlt().solve(Eigen::VectorXd::Unit(x.size(), 0));
    load.swing.length_deviation_m =
        correlated * load.swing.length_m *
        std::sqrt(std::max(0.0, column[0]) * best / std::max(1.0, problem.rows() - static_cast<double>(x.size())));
  }
  for (std::size_t f = 0; f < starts.size(); ++f) starts[f] = unpack(problem.start(x, f));
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
