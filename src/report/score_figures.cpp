#include "report/score_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "metrics/statistics.hpp"
#include "util/quantiles.hpp"

namespace gustlab {

namespace {

using Json = nlohmann::ordered_json;

constexpr double two_sided_95 = 1.959963984540054;  // normal quantile of 0.975
// lower ends of the strength bins, in detection limits
constexpr std::array<double, 6> strength_edges{0.0, 1.0, 2.0, 3.0, 5.0, 8.0};

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::size_t strength_bin(double strength) {
  std::size_t bin = 0;
  // strengths are products: 2.9999999 belongs to 3
  while (bin + 1 < strength_edges.size() && strength >= strength_edges[bin + 1] * (1.0 - 1e-6)) ++bin;
  return bin;
}

struct Count {
  std::size_t k = 0, n = 0;
  void add(bool good) { ++n, k += good ? 1 : 0; }
};

struct ParameterCount {
  std::vector<double> error, relative;
  Count covered;
};

void add_parameters(const Json& truth, const Json& fitted, const std::string& effect,
                    std::map<std::string, ParameterCount>& counts) {
  for (const auto& [name, value] : truth.items()) {
    if (!fitted.contains(name) || !value.is_number()) continue;
    const Json& entry = fitted.at(name);
    // the size of a vector-like effect, so that a component near zero is not judged by itself
    double square = 0.0;
    for (const auto& [other, component] : truth.items())
      if (component.is_number() && fitted.contains(other) &&
          fitted.at(other).value("unit", "") == entry.value("unit", ""))
        square += component.get<double>() * component.get<double>();
    const double error = std::abs(entry.value("value", std::numeric_limits<double>::quiet_NaN()) - value.get<double>());
    ParameterCount& count = counts[effect + "." + name];
    count.error.push_back(error);
    if (square > 0.0) count.relative.push_back(error / std::sqrt(square));
    count.covered.add(error <= two_sided_95 * entry.value("std", 0.0));
  }
}

}  // namespace

nlohmann::ordered_json score_rate(std::size_t k, std::size_t n) {
  if (n == 0) return {{"k", 0}, {"n", 0}, {"share", nullptr}, {"low", nullptr}, {"high", nullptr}};
  const Interval interval = wilson_interval(k, n);
  const double share = static_cast<double>(k) / static_cast<double>(n);
  return {{"k", k}, {"n", n}, {"share", share}, {"low", interval.low}, {"high", interval.high}};
}

nlohmann::ordered_json score_power(const std::vector<ScoredTrial>& trials) {
  std::map<std::string, std::array<Count, strength_edges.size()>> found;
  std::array<Count, strength_edges.size()> exact;
  for (const ScoredTrial& trial : trials) {
    if (trial.outside()) continue;
    for (std::size_t i = 0; i < trial.truth.size(); ++i) {
      const double strength = trial.truth[i].strength;
      if (std::isnan(strength)) continue;
      found[trial.truth[i].effect][strength_bin(strength)].add(trial.partner[i] >= 0);
      if (trial.truth.size() == 1) exact[strength_bin(strength)].add(trial.exact());
    }
  }
  const auto bins = [](const auto& counts) {
    Json row = Json::array();
    for (const Count& count : counts) row.push_back(score_rate(count.k, count.n));
    return row;
  };
  std::array<Count, strength_edges.size()> all{};
  Json effects = Json::object();
  for (const auto& [effect, counts] : found) {
    effects[effect] = bins(counts);
    for (std::size_t b = 0; b < all.size(); ++b) all[b].k += counts[b].k, all[b].n += counts[b].n;
  }
  return {{"strength_from", strength_edges}, {"single_exact", bins(exact)}, {"named", bins(all)}, {"effects", effects}};
}

nlohmann::ordered_json score_parameters(const std::vector<ScoredTrial>& trials) {
  std::map<std::string, ParameterCount> counts;
  for (const ScoredTrial& trial : trials)
    for (std::size_t i = 0; i < trial.truth.size(); ++i) {
      if (trial.partner[i] < 0) continue;
      const Concealed& truth = trial.truth[i];
      const Named& name = trial.named[static_cast<std::size_t>(trial.partner[i])];
      if (name.effect != truth.effect) continue;
      if (truth.per_flight.empty() || name.per_flight.empty()) {
        add_parameters(truth.parameters, name.parameters, truth.effect, counts);
        continue;
      }
      for (const auto& [flight, values] : truth.per_flight.items())
        if (name.per_flight.contains(flight)) add_parameters(values, name.per_flight.at(flight), truth.effect, counts);
    }

  Count all;
  Json table = Json::array();
  for (const auto& [label, count] : counts) {
    const double error = summarize(count.error).median;
    const double relative = summarize(count.relative).median;
    table.push_back({{"parameter", label},
                     {"median_error", number_or_null(error)},
                     {"median_relative_error", number_or_null(relative)},
                     {"coverage", score_rate(count.covered.k, count.covered.n)}});
    all.k += count.covered.k;
    all.n += count.covered.n;
  }
  return {{"coverage", score_rate(all.k, all.n)}, {"each", table}};
}

nlohmann::ordered_json score_reliability(const std::vector<ScoredTrial>& trials) {
  struct Bin {
    Count right;
    double confidence = 0.0;
  };
  std::array<Bin, 10> bins;
  std::size_t n = 0;
  double brier = 0.0;
  const auto add = [&](double said, bool right) {
    const double confidence = std::clamp(said, 0.0, 1.0);
    Bin& bin = bins[std::min<std::size_t>(9, static_cast<std::size_t>(confidence * 10.0))];
    bin.right.add(right);
    bin.confidence += confidence;
    brier += std::pow(confidence - (right ? 1.0 : 0.0), 2);
    ++n;
  };
  for (const ScoredTrial& trial : trials) {
    for (std::size_t i = 0; i < trial.named.size(); ++i) add(trial.named[i].confidence, trial.right[i]);
    for (const Named& name : trial.suspected)
      add(name.confidence, std::any_of(trial.truth.begin(), trial.truth.end(),
                                       [&](const Concealed& truth) { return matches(name, truth); }));
  }
  double error = 0.0;
  Json rows = Json::array();
  for (std::size_t b = 0; b < bins.size(); ++b) {
    if (bins[b].right.n == 0) continue;
    const auto count = static_cast<double>(bins[b].right.n);
    const double said = bins[b].confidence / count, was = static_cast<double>(bins[b].right.k) / count;
    error += count / static_cast<double>(n) * std::abs(said - was);
    rows.push_back({{"from", static_cast<double>(b) / 10.0},
                    {"said", said},
                    {"right", score_rate(bins[b].right.k, bins[b].right.n)}});
  }
  return {{"findings", n},
          {"expected_calibration_error", n > 0 ? Json(error) : Json(nullptr)},
          {"brier", n > 0 ? Json(brier / static_cast<double>(n)) : Json(nullptr)},
          {"bins", rows}};
}

nlohmann::ordered_json score_closure(const std::vector<ScoredTrial>& trials) {
  const std::array<std::string, 4> quantities{"position_m", "velocity_mps", "attitude_rad", "body_rate_radps"};
  std::map<std::string, std::map<double, std::vector<double>>> shares;
  std::size_t wanted = 0;
  for (const ScoredTrial& trial : trials) {
    if (trial.truth.empty() || trial.outside() || !trial.above_limit()) continue;
    ++wanted;
    if (!trial.fit.contains("horizon_s")) continue;
    const std::vector<double> horizons = trial.fit.at("horizon_s").get<std::vector<double>>();
    for (const std::string& quantity : quantities) {
      if (!trial.fit.contains(quantity)) continue;
      const Json& errors = trial.fit.at(quantity);
      const Json oracle = trial.oracle.contains(quantity) ? trial.oracle.at(quantity).at("after") : Json::array();
      for (std::size_t h = 0; h < horizons.size(); ++h) {
        const Json &before = errors.at("before").at(h), &after = errors.at("after").at(h),
                   &noise = errors.at("noise").at(h);
        if (!before.is_number() || !after.is_number() || !noise.is_number()) continue;
        // the oracle's errors are free of measurement noise, which adds in squares
        const double least = std::hypot(noise.get<double>(), h < oracle.size() ? oracle.at(h).get<double>() : 0.0);
        // where nothing can be recovered, nothing can be closed
        const double room = before.get<double>() - least;
        if (room < 0.1 * before.get<double>()) continue;
        shares[quantity][horizons[h]].push_back((before.get<double>() - after.get<double>()) / room);
      }
    }
  }
  Json rows = Json::array();
  for (const std::string& quantity : quantities)
    for (auto& [horizon, values] : shares[quantity])
      rows.push_back({{"quantity", quantity},
                      {"horizon_s", horizon},
                      {"trials", values.size()},
                      {"q25", quantile(values, 0.25)},
                      {"median", quantile(values, 0.5)},
                      {"q75", quantile(values, 0.75)}});
  return {{"trials_above_limit", wanted}, {"each", rows}};
}

}  // namespace gustlab
