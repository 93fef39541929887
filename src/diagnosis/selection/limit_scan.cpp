#include "diagnosis/selection/limit_scan.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/model/linear_model.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::fewest_limited_samples, decisions::least_limit_strength;

// limits at the upper quantiles of what was commanded
std::vector<double> limits_to_try(const Session& session) {
  const VehicleModel& vehicle = session.vehicle();
  std::vector<double> speeds, limits;
  for (const FlightData& flight : session.flights()) {
    if (!flight.measured_speed.empty()) return {};
    for (const Sample& sample : flight.samples) {
      const RotorArray mean = flight.commands.mean(sample.time_s, sample.time_s + flight.sample_s);
      for (int i = 0; i < vehicle.rotor_count; ++i)
        speeds.push_back(std::min(mean[static_cast<std::size_t>(i)], vehicle.max_speed_radps));
    }
  }
  std::sort(speeds.rbegin(), speeds.rend());
  for (const double share : {0.0005, 0.001, 0.002, 0.004, 0.007, 0.011, 0.017, 0.026, 0.04, 0.06, 0.09, 0.13}) {
    const double limit = speeds[static_cast<std::size_t>(share * static_cast<double>(speeds.size()))];
    if (limit > 1.02 * vehicle.hover_speed_radps() && limit < 0.999 * vehicle.max_speed_radps) limits.push_back(limit);
  }
  return limits;
}

// the best of some limits
LimitScan best_of(const Session& session, const std::vector<int>& columns, const Eigen::VectorXd& coefficient,
                  const std::vector<double>& limits) {
  LimitScan best;
  const auto count = static_cast<Eigen::Index>(limits.size());
  std::vector<std::vector<SpatialAccelerations>> change(session.flights().size());
  session.for_each_flight([&](std::size_t f) {
    const FlightData& flight = session.flights()[f];
    change[f].assign(flight.samples.size(), SpatialAccelerations::Zero(6, count));
    const auto changes = limit_changes(flight, static_cast<int>(f), session.catalogue(), session.value(), limits);
    for (std::size_t i = 0; i < limits.size(); ++i)
      for (std::size_t k = 0; k < changes[i].size(); ++k)
        change[f][k].col(static_cast<Eigen::Index>(i)) = changes[i][k];
  });
  std::vector<double> samples(limits.size(), 0.0);
  for (const auto& flight : change)
    for (const SpatialAccelerations& sample : flight)
      for (std::size_t i = 0; i < limits.size(); ++i)
        samples[i] += sample.col(static_cast<Eigen::Index>(i)).isZero(0.0) ? 0.0 : 1.0;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count + 1, count + 1);
  for (const Whitened& w : session.innovations(columns, coefficient, &change))
    for (Eigen::Index r = 0; r < w.rows.rows(); ++r)
      if (w.warm[static_cast<std::size_t>(r)]) gram += w.rows.row(r).transpose() * w.rows.row(r);
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double dp = gram(at, count), pp = gram(at, at);
    if (samples[i] < fewest_limited_samples || pp <= 0.0 || dp < least_limit_strength * pp) continue;
    if (dp * dp / pp > best.delta_chi2) best = {limits[i], dp * dp / pp};
  }
  return best;
}

}  // namespace

LimitScan scan_limit(const Session& session, const std::vector<int>& columns) {
  const std::vector<double> limits = limits_to_try(session);
  if (limits.empty()) return {};
  const Eigen::VectorXd coefficient = solve(session.grams(columns).total(), columns).coefficient;
  const LimitScan coarse = best_of(session, columns, coefficient, limits);
  if (coarse.delta_chi2 == 0.0) return coarse;
  // and between its neighbours
  const auto at = std::find(limits.begin(), limits.end(), coarse.limit_radps);
  const double above = at == limits.begin() ? session.vehicle().max_speed_radps : at[-1],
               below = at + 1 == limits.end() ? *at : at[1];
  std::vector<double> between;
  for (const double share : {0.2, 0.4, 0.6, 0.8})
    between.push_back(*at + share * (above - *at)), between.push_back(*at + share * (below - *at));
  const LimitScan fine = best_of(session, columns, coefficient, between);
  return fine.delta_chi2 > coarse.delta_chi2 ? fine : coarse;
}

}  // namespace gustlab::diagnosis
