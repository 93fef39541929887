#include "limit.hpp"

#include <algorithm>
#include <cmath>

namespace reality {
namespace {

constexpr double kMateriality = 0.0025;  // of the degrees of freedom, DIAGNOSIS.md 3.6
constexpr double kFiveSigma = 25;

Information inform(const Scene& scene, const std::vector<Probe>& probes) {
  std::vector<const Flight*> flights;
  for (const Flight& f : scene.flight) flights.push_back(&f);
  return information(flights, scene.base, probes, scene.columns, scene.noise);
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

// the calibration tolerance in strengths along the plan's direction: the first parameter to pass its own
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

// Whittle gain of a gust over turbulence alone: spectra of both below 3 Hz, three axes, and the line's energy
double gust_gain(const Plan& plan, const Scene& scene, double strength) {
  const Nominal& n = scene.base.front().nominal;
  const Values v = values_at(plan, n, strength, 0);
  const auto get = [&](const char* name) { return v.count(name) ? v.at(name) : 0.0; };
  const auto spectrum = [](double sigma, double time_s, double radps) {
    return 2 * sigma * sigma * time_s / (1 + std::pow(radps * time_s, 2));
  };
  const Noise& noise = scene.noise;
  double gain = 0;
  for (int bin = 1; bin <= 3 * kFlight_s; ++bin) {
    const double radps = 2 * std::numbers::pi * bin / kFlight_s;
    const double calm = spectrum(noise.air_mps2, noise.air_time_s, radps);
    for (const double sigma_N : {get("sigma_xy"), get("sigma_xy"), get("sigma_z")}) {
      const double ratio = spectrum(sigma_N / n.mass_kg, get("correlation_time"), radps) / calm;
      gain += 2 * (ratio - std::log1p(ratio));
    }
  }
  const double line_calm = spectrum(noise.air_mps2, noise.air_time_s, get("line_frequency"));
  gain += 2 * std::pow(get("line_amplitude") / n.mass_kg, 2) * kFlight_s / (2 * line_calm);
  return static_cast<double>(scene.base.size()) * gain;
}

double gust_strength(const Plan& plan, const Scene& scene, double gain) {
  double low = 1e-4, high = 1e4;
  while (high / low > 1 + 1e-9) {
    const double middle = std::sqrt(low * high);
    (gust_gain(plan, scene, middle) < gain ? low : high) = middle;
  }
  return low;
}

Limit largest(Limit limit) {
  limit.strength = std::max({limit.tolerance, limit.materiality, limit.five_sigma});
  return limit;
}

}  // namespace

double measurements(const Scene& scene) {
  const double each = 9 + (scene.columns.velocity ? 3 : 0) + (scene.columns.accel ? 3 : 0);
  double samples = 0;
  for (const Flight& f : scene.flight) samples += static_cast<double>(f.sample.size());
  return each * samples;
}

double threshold(const Scene& scene) { return std::max(kFiveSigma, kMateriality * measurements(scene)); }

Limit detection_limit(const Plan& plan, const Scene& scene, const Pushes& load_push) {
  const double material = kMateriality * measurements(scene);
  if (plan.effect == "gust")
    return largest({0, 0, gust_strength(plan, scene, material), gust_strength(plan, scene, kFiveSigma)});
  const bool large = scene.base.front().nominal.large;
  double weight = 0;
  if (load_push.empty()) {
    weight = inform(scene, {probe(plan, scene, 1e-3)}).matrix(0, 0);
  } else {
    // a load that hangs still is mass: only its swinging tells
    Probe load;
    load.push = load_push;
    const Eigen::MatrixXd both = inform(scene, {load, probe({"mass", {{{"delta", 1.0}}}, {}}, scene, 1e-3)}).matrix;
    weight = (both(0, 0) - both(0, 1) * both(1, 0) / both(1, 1)) *
             std::pow(effect(plan.effect).parameter[0].natural[large], 2);
  }
  return largest({0, tolerance(plan, large), std::sqrt(material / weight), std::sqrt(kFiveSigma / weight)});
}

Bite saturation_bite(const Plan& plan, const Scene& scene, double factor) {
  constexpr int kGrid = 16;
  std::vector<double> strength{0}, weight{0};
  std::vector<Probe> probes;
  for (int i = 1; i <= kGrid; ++i) {
    strength.push_back(effect(plan.effect).most * i / kGrid);
    probes.push_back(probe(plan, scene, strength.back()));
    probes.back().step = 1;
  }
  const Information info = inform(scene, probes);
  for (int i = 0; i < kGrid; ++i) weight.push_back(std::sqrt(info.matrix(i, i)));
  const auto reach = [&](double root) {
    for (std::size_t i = 1; i < weight.size(); ++i)
      if (weight[i] >= root)
        return strength[i - 1] + (strength[i] - strength[i - 1]) * (root - weight[i - 1]) / (weight[i] - weight[i - 1]);
    return strength.back();
  };
  const double unit = std::sqrt(threshold(scene));
  Bite bite;
  bite.factor = std::min(factor, weight.back() / unit);
  bite.strength = reach(bite.factor * unit);
  bite.limit = largest({0, 0, reach(std::sqrt(kMateriality * measurements(scene))), reach(std::sqrt(kFiveSigma))});
  return bite;
}

double visibility(const std::vector<Truth>& with, const Pushes& pushes, const Scene& scene) {
  Probe p;
  p.changed = with;
  p.push = pushes;
  return std::sqrt(inform(scene, {p}).matrix(0, 0) / threshold(scene));
}

}  // namespace reality
