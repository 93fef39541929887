#include "diagnosis/selection/limit_scan.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/estimation/rotor_speeds.hpp"
#include "diagnosis/model/linear_model.hpp"
#include "diagnosis/model/speed_comparison.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::fewest_limited_samples, decisions::least_limit_strength;

// limits at the upper quantiles of what was commanded, and of what was measured
std::vector<double> limits_to_try(const Session& session) {
  const VehicleModel& vehicle = session.vehicle();
  std::vector<double> commanded, measured, limits;
  const auto add = [&](const RotorArray& speeds, std::vector<double>& to) {
    for (int i = 0; i < vehicle.rotor_count; ++i)
      to.push_back(std::min(speeds[static_cast<std::size_t>(i)], vehicle.max_speed_radps));
  };
  for (const FlightData& flight : session.flights()) {
    for (const Sample& sample : flight.samples)
      add(flight.commands.mean(sample.time_s, sample.time_s + flight.sample_s), commanded);
    for (const RotorArray& speeds : flight.measured_at_sample) add(speeds, measured);
  }
  for (std::vector<double>* speeds : {&commanded, &measured}) {
    std::sort(speeds->rbegin(), speeds->rend());
    for (const double share : {0.0005, 0.001, 0.002, 0.004, 0.007, 0.011, 0.017, 0.026, 0.04, 0.06, 0.09, 0.13}) {
      if (speeds->empty()) continue;
      const double limit = (*speeds)[static_cast<std::size_t>(share * static_cast<double>(speeds->size()))];
      if (limit > 1.02 * vehicle.hover_speed_radps() && limit < 0.999 * vehicle.max_speed_radps)
        limits.push_back(limit);
    }
  }
  std::sort(limits.rbegin(), limits.rend());
  return limits;
}

Eigen::MatrixXd gram_of(const std::vector<Whitened>& flights, Eigen::Index count) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count + 1, count + 1);
  for (const Whitened& w : flights)
    for (Eigen::Index r = 0; r < w.rows.rows(); ++r)
      if (w.warm[static_cast<std::size_t>(r)]) gram += w.rows.row(r).transpose() * w.rows.row(r);
  return gram;
}

// What limits and the innovations that nothing explains do together: [limits | z]ᵀ[limits | z]; `samples` counts those that each changes.
Eigen::MatrixXd gram_of_body(const Session& session, const std::vector<int>& columns,
                             const Eigen::VectorXd& coefficient, const std::vector<double>& limits,
                             std::vector<double>& samples) {
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
  for (const auto& flight : change)
    for (const SpatialAccelerations& sample : flight)
      for (std::size_t i = 0; i < limits.size(); ++i)
        samples[i] += sample.col(static_cast<Eigen::Index>(i)).isZero(0.0) ? 0.0 : 1.0;
  return gram_of(session.innovations(columns, coefficient, &change), count);
}

// the same where measured speeds drive the body, and say themselves how fast rotors turned
Eigen::MatrixXd gram_of_speeds(const Session& session, const std::vector<int>& columns,
                               const Eigen::VectorXd& coefficient, const std::vector<double>& limits,
                               std::vector<double>& samples) {
  std::vector<Whitened> whitened(session.flights().size());
  for (std::size_t f = 0; f < whitened.size(); ++f) {
    const FlightData& flight = session.flights()[f];
    LinearFlight rest = taken_out(session.linear()[f], columns, coefficient);
    if (rest.predicted.empty()) continue;
    rest.columns.resize(limits.size());
    rest.predicted_by = limit_speed_changes(flight, static_cast<int>(f), session.catalogue(), session.value(), limits);
    for (std::size_t i = 0; i < limits.size(); ++i)
      samples[i] += static_cast<double>(std::ranges::count_if(rest.predicted_by[i], [](const RotorArray& change) {
        return std::ranges::any_of(change, [](double c) { return c != 0.0; });
      }));
    whitened[f] = whiten_speeds(flight, rest, session.noise.speeds);
  }
  return gram_of(whitened, static_cast<Eigen::Index>(limits.size()));
}

// the best of some limits
LimitScan best_of(const Session& session, const std::vector<int>& columns, const Eigen::VectorXd& coefficient,
                  const std::vector<double>& limits) {
  LimitScan best;
  const auto count = static_cast<Eigen::Index>(limits.size());
  std::vector<double> samples(limits.size(), 0.0);
  const bool measured =
      std::ranges::any_of(session.flights(), [](const FlightData& f) { return !f.measured_speed.empty(); });
  const Eigen::MatrixXd gram =
      (measured ? gram_of_speeds : gram_of_body)(session, columns, coefficient, limits, samples);
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
