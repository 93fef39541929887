#include "limit.hpp"

#include <algorithm>
#include <cmath>

namespace reality {
namespace {

std::vector<const Flight*> pointers(const Scene& scene) {
  std::vector<const Flight*> all;
  for (const Flight& f : scene.flight) all.push_back(&f);
  return all;
}

Probe probe(const Plan& plan, const Scene& scene, double strength) {
  Probe p;
  p.step = strength;
  for (std::size_t n = 0; n < scene.base.size(); ++n) {
    Truth changed = scene.base[n];
    plant(changed, plan.effect, values_at(plan, changed.nominal, strength, n));
    p.changed.push_back(changed);
  }
  return p;
}

// the calibration tolerance in strengths along the plan's direction
double tolerance(const Plan& plan, bool large) {
  double limit = 0;
  for (const Parameter& p : effect(plan.effect).parameter) {
    const auto it = plan.direction.front().find(p.name);
    if (it == plan.direction.front().end() || it->second == 0 || p.tolerance[large] == 0) continue;
    const double own = p.tolerance[large] / (std::abs(it->second) * p.natural[large]);
    limit = limit == 0 ? own : std::min(limit, own);
  }
  return limit;
}

}  // namespace

double threshold(double samples) { return std::max(25.0, 0.0025 * samples); }

Values values_at(const Plan& plan, const Nominal& nominal, double strength, std::size_t flight) {
  Values values = plan.fixed;
  const auto& direction = plan.direction.size() == 1 ? plan.direction.front() : plan.direction[flight];
  for (const Parameter& p : effect(plan.effect).parameter)
    if (const auto it = direction.find(p.name); it != direction.end())
      values[p.name] = nominal_value(nominal, plan.effect, p.name) +
                       (plan.effect == "saturation" ? -1 : 1) * strength * it->second * p.natural[nominal.large];
  return values;
}

Limit detection_limit(const Plan& plan, const Scene& scene,
                      const std::vector<std::vector<Eigen::Matrix<double, 6, 1>>>& load_push) {
  const Nominal& nominal = scene.base.front().nominal;
  std::vector<Probe> probes;
  if (plan.effect == "slung_load") {
    Probe load;
    load.push = load_push;
    load.step = 1;
    probes.push_back(load);
    probes.push_back(probe({"mass", {{{"delta", 1.0}}}, {}}, scene, 1e-3));
  } else {
    probes.push_back(probe(plan, scene, 1e-3));
  }
  const Information info = information(pointers(scene), scene.base, probes, scene.columns, scene.noise);
  double weight = info.matrix(0, 0);
  if (plan.effect == "slung_load") {
    // what hangs still is mass: only the swinging part tells
    weight -= info.matrix(0, 1) * info.matrix(1, 0) / info.matrix(1, 1);
    weight *= std::pow(effect(plan.effect).parameter[0].natural[nominal.large], 2);
  }
  Limit limit;
  limit.tolerance = tolerance(plan, nominal.large);
  limit.materiality = std::sqrt(0.0025 * info.samples / weight);
  limit.five_sigma = 5 / std::sqrt(weight);
  limit.strength = std::max({limit.tolerance, limit.materiality, limit.five_sigma});
  return limit;
}

std::pair<double, Limit> saturation_strength(const Plan& plan, const Scene& scene, double factor) {
  std::vector<Probe> probes;
  std::vector<double> strength;
  const double most = effect(plan.effect).most;
  for (int i = 1; i <= 16; ++i) strength.push_back(most * i / 16);
  for (const double s : strength) {
    probes.push_back(probe(plan, scene, s));
    probes.back().step = 1;
  }
  const Information info = information(pointers(scene), scene.base, probes, scene.columns, scene.noise);
  const auto reaches = [&](double gain) {
    double last_s = 0, last = 0;
    for (std::size_t i = 0; i < strength.size(); ++i) {
      const double now = info.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      if (now >= gain) return last_s + (strength[i] - last_s) * (std::sqrt(gain) - last) / (std::sqrt(now) - last);
      last_s = strength[i];
      last = std::sqrt(now);
    }
    return 0.0;
  };
  Limit limit;
  limit.strength = reaches(threshold(info.samples));
  limit.materiality = reaches(0.0025 * info.samples);
  limit.five_sigma = reaches(25);
  return {reaches(factor * factor * threshold(info.samples)), limit};
}

}  // namespace reality
