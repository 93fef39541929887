#include "draw.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "limit.hpp"
#include "vehicle.hpp"

namespace reality {
namespace {

using Json = nlohmann::ordered_json;

enum Stream : std::uint64_t { kWhat = 0, kScatter = 1, kPaths = 2, kAirBaseline = 100, kAir = 200 };

// effects that look alike by an exact alias, never drawn together
bool aliases(const std::string& a, const std::string& b) {
  static const std::vector<std::vector<std::string>> same{{"mass", "thrust_scale"},
                                                          {"attitude_offset", "rotor_tilt"},
                                                          {"inertia", "yaw_torque_ratio"},
                                                          {"mass", "constant_force"},
                                                          {"mass", "slung_load"}};
  return std::any_of(same.begin(), same.end(), [&](const auto& pair) {
    return (pair[0] == a && pair[1] == b) || (pair[0] == b && pair[1] == a);
  });
}

// small errors of the maker's numbers; `size` is their share of the reporting tolerances
void scatter(Truth& t, double size, Rng& rng) {
  const auto share = [&](double tolerance) { return size * tolerance * rng.uniform(-1, 1); };
  const bool large = t.nominal.large;
  const double com = effect("center_of_mass").parameter[0].tolerance[large];
  // each combination that acts alike stays below the tolerance of one
  t.mass_kg *= 1 + 0.5 * share(0.012);
  t.thrust_scale *= 1 + 0.5 * share(0.012);
  for (double& gain : t.rotor_gain) gain *= 1 + 0.15 * share(0.01);
  t.com_B_m += 0.45 * Vec3(share(com), share(com), share(com));
  for (int i = 0; i < 3; ++i) t.inertia_kgm2[i] *= 1 + 0.6 * share(0.05);
  t.torque_ratio_m *= 1 + 0.35 * share(0.05);
  const double lag = 0.6 * share(0.004);
  t.lag_up_s += lag;
  t.lag_down_s += lag;
}

Plan draw_plan(const std::string& name, bool voltage_logged, Rng& rng) {
  const Effect& e = effect(name);
  Plan plan;
  plan.effect = name;
  const std::size_t copies = e.whole_vehicle ? 1 : kFitFlights + 1;
  for (std::size_t n = 0; n < copies; ++n) {
    std::map<std::string, double> d;
    if (name == "battery_sag") {
      d[voltage_logged ? "exponent" : "rate"] = 1;
    } else if (name == "motor_lag") {
      const double up = rng.uniform(0.6, 1.0), down = rng.chance(0.6) ? up : rng.uniform(0.6, 1.0);
      const double side = rng.chance(0.75) ? 1 : -1;
      d = {{"time_constant", side * up}, {"time_constant_down", side * down}};
    } else if (name == "quadratic_drag") {
      d = {{"area_xy", rng.uniform(0.6, 1.0)}, {"area_z", rng.uniform(0.4, 1.2)}};
    } else {
      double norm = 0;
      for (const Parameter& p : e.parameter) {
        const double x = e.parameter.size() == 1 ? 1 : rng.normal();
        d[p.name] = x;
        norm += x * x;
      }
      const double side = e.both_signs ? rng.sign() : 1;
      const double size = copies > 1 ? rng.uniform(0.7, 1.2) : 1;
      for (auto& [key, value] : d) value *= side * size / std::sqrt(norm);
    }
    plan.direction.push_back(d);
  }
  if (name == "rotor_loss") plan.fixed["rotor"] = 1 + rng.below(kRotors);
  return plan;
}

double most_strength(const Plan& plan, const Nominal& nominal) {
  double most = effect(plan.effect).most;
  if (plan.effect == "motor_lag")
    for (const auto& [name, share] : plan.direction.front())
      if (share < 0) most = std::min(most, 0.7 * nominal.motor_lag_s / (-share * effect("motor_lag").parameter[0].natural[nominal.large]));
  return most;
}

Surroundings draw_surroundings(const std::vector<std::string>& effects, bool large, Rng& rng) {
  const auto needs = [&](Need need) {
    return std::any_of(effects.begin(), effects.end(), [&](const auto& name) { return effect(name).need == need; });
  };
  Surroundings s;
  // decoys keep the sidecar from telling what a trial conceals
  if (rng.chance(0.45) || needs(Need::ground)) s.ground_z_m = 0;
  if (rng.chance(0.15) || needs(Need::ceiling)) s.ceiling_z_m = large ? 6.0 : 2.0;
  if (rng.chance(0.15) || needs(Need::wall)) {
    const double heading = rng.uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector2d inward(std::cos(heading), std::sin(heading));
    s.wall = Wall{-(large ? 8.0 : 1.75) * inward, inward};
  }
  return s;
}

std::vector<Path> draw_paths(const Nominal& vehicle, const Surroundings& around, double gentleness,
                             const Request& request, std::uint64_t index, int attempt) {
  std::vector<Path> paths;
  const Figure figure[] = {Figure::circle, Figure::staircase, Figure::waypoints, Figure::holdout};
  for (std::uint64_t n = 0; n < 4; ++n) {
    Rng rng(request.seed, index, kPaths + 10 * (n + 1) + 1000 * static_cast<std::uint64_t>(attempt));
    paths.push_back(draw_path(figure[n], vehicle, around, gentleness, rng));
  }
  return paths;
}

bool lost(const std::vector<Flight>& flights) {
  return std::any_of(flights.begin(), flights.end(), [](const Flight& f) { return f.lost; });
}

// cable force per kilogram of a light load along the fit flights
std::vector<std::vector<Eigen::Matrix<double, 6, 1>>> load_history(const Plan& plan, const Scene& scene,
                                                                   const std::vector<Path>& paths,
                                                                   const Request& request, std::uint64_t index) {
  std::vector<std::vector<Eigen::Matrix<double, 6, 1>>> push;
  for (std::size_t n = 0; n < scene.base.size(); ++n) {
    Truth loaded = scene.base[n];
    plant(loaded, plan.effect, values_at(plan, loaded.nominal, 0.5, n));
    const Flight flight = fly(loaded, paths[n], scene.noise, request.seed, index, kAirBaseline + 10 * n);
    std::vector<Eigen::Matrix<double, 6, 1>> history(scene.flight[n].sample.size(), Eigen::Matrix<double, 6, 1>::Zero());
    for (std::size_t k = 0; k < std::min(history.size(), flight.sample.size()); ++k)
      history[k].head<3>() = flight.sample[k].extra_force_W_N / loaded.load_kg;
    push.push_back(history);
  }
  return push;
}

Json describe(const Plan& plan, const Nominal& nominal, double strength, const Limit& limit) {
  Json entry;
  entry["effect"] = plan.effect;
  Json parameters = Json::object();
  std::map<std::string, double> mean;
  for (std::size_t n = 0; n < kFitFlights; ++n)
    for (const auto& [name, value] : values_at(plan, nominal, strength, n)) mean[name] += value / kFitFlights;
  for (const auto& [name, value] : mean) parameters[name] = value;
  if (plan.fixed.count("rotor")) parameters["rotor"] = static_cast<int>(plan.fixed.at("rotor"));
  entry["parameters"] = parameters;
  if (plan.direction.size() > 1) {
    Json flights = Json::object();
    for (std::size_t n = 0; n <= kFitFlights; ++n) {
      const std::string file = n < kFitFlights ? "fit_" + std::to_string(n + 1) + ".csv" : "holdout_1.csv";
      for (const auto& [name, value] : values_at(plan, nominal, strength, n)) flights[file][name] = value;
    }
    entry["per_flight"] = flights;
  }
  entry["strength_over_limit"] = limit.strength > 0 ? strength / limit.strength : 0.0;
  entry["limit_share"] = {{"tolerance", limit.strength > 0 ? limit.tolerance / limit.strength : 0},
                          {"materiality", limit.strength > 0 ? limit.materiality / limit.strength : 0},
                          {"five_sigma", limit.strength > 0 ? limit.five_sigma / limit.strength : 0}};
  return entry;
}

struct Setting {
  std::string kind;
  bool large = false;
  int noise = 1;
  std::vector<std::string> effects;
};

std::string draw_effect(Rng& rng) {
  const auto& all = catalogue();
  return all[static_cast<std::size_t>(rng.below(static_cast<int>(all.size())))].name;
}

Setting draw_setting(const Request& request, Rng& rng) {
  Setting s;
  const double lot = rng.uniform();
  s.kind = request.effect ? "single" : request.kind;
  if (s.kind == "mixed") s.kind = lot < 0.25 ? "clean" : lot < 0.35 ? "scatter" : lot < 0.75 ? "single" : "pair";
  s.large = rng.chance(0.4);
  s.noise = rng.chance(0.5) ? 1 : 2;
  s.large = request.large.value_or(s.large);
  s.noise = request.noise.value_or(s.noise);
  if (s.kind == "single") s.effects = {request.effect ? *request.effect : draw_effect(rng)};
  if (s.kind == "pair") {
    s.effects = {draw_effect(rng), draw_effect(rng)};
    while (s.effects[0] == s.effects[1] || aliases(s.effects[0], s.effects[1])) s.effects[1] = draw_effect(rng);
  }
  for (const auto& name : s.effects) effect(name);
  return s;
}

}  // namespace

Trial draw_trial(const Request& request, std::uint64_t index) {
  Rng rng(request.seed, index, kWhat);
  const Setting setting = draw_setting(request, rng);
  const auto needs = [&](Need need) {
    return std::any_of(setting.effects.begin(), setting.effects.end(),
                       [&](const auto& name) { return effect(name).need == need; });
  };
  Trial trial;
  const bool drag_known = rng.chance(0.25) || needs(Need::drag);
  trial.vehicle = nominal_vehicle(setting.large, drag_known);
  trial.columns.velocity = rng.chance(0.8);
  trial.columns.accel = rng.chance(0.35) || needs(Need::accel);
  trial.columns.voltage = rng.chance(0.45);
  trial.surroundings = draw_surroundings(setting.effects, setting.large, rng);
  std::vector<Plan> plans;
  for (const auto& name : setting.effects) plans.push_back(draw_plan(name, trial.columns.voltage, rng));
  for (Plan& plan : plans)
    if (plan.effect == "slung_load") plan.fixed["length"] = setting.large ? rng.uniform(0.5, 2.0) : rng.uniform(0.15, 0.5);
  std::vector<double> factor;
  for (std::size_t i = 0; i < plans.size(); ++i) factor.push_back(request.factor.value_or(rng.log_uniform(0.3, 10)));

  Truth base = as_nominal(trial.vehicle);
  base.surroundings = trial.surroundings;
  Rng scatter_rng(request.seed, index, kScatter);
  scatter(base, setting.kind == "scatter" ? scatter_rng.uniform(0.5, 1.0) : 0.1, scatter_rng);
  // what is concealed carries no scatter of its own
  for (const Plan& plan : plans) plant(base, plan.effect, values_at(plan, trial.vehicle, 0, 0));
  Scene scene;
  scene.columns = trial.columns;
  scene.noise = noise_level(setting.large, setting.noise);
  scene.base.assign(kFitFlights, base);

  double gentleness = 1;
  bool flown = false;
  Json named = Json::array();
  for (int attempt = 0; attempt < 16 && !flown; ++attempt, gentleness *= 0.9) {
    const auto paths = draw_paths(trial.vehicle, trial.surroundings, gentleness, request, index, attempt);
    std::vector<Truth> truth(kFitFlights + 1, base);
    named.clear();
    if (!plans.empty()) {
      scene.flight.clear();
      for (std::size_t n = 0; n < kFitFlights; ++n)
        scene.flight.push_back(fly(base, paths[n], scene.noise, request.seed, index, kAirBaseline + 10 * n));
      if (lost(scene.flight)) continue;
    }
    for (std::size_t i = 0; i < plans.size(); ++i) {
      const Plan& plan = plans[i];
      Limit limit;
      double strength = 0;
      const double most = most_strength(plan, trial.vehicle) * std::pow(0.85, std::max(0, attempt - 7));
      if (plan.effect == "saturation") {
        std::tie(strength, limit) = saturation_strength(plan, scene, factor[i]);
        if (strength == 0) strength = most;
      } else {
        const bool load = plan.effect == "slung_load";
        limit = detection_limit(plan, scene, load ? load_history(plan, scene, paths, request, index)
                                                  : std::vector<std::vector<Eigen::Matrix<double, 6, 1>>>{});
        strength = std::min(factor[i] * limit.strength, most);
      }
      for (std::size_t n = 0; n <= kFitFlights; ++n) plant(truth[n], plan.effect, values_at(plan, trial.vehicle, strength, n));
      named.push_back(describe(plan, trial.vehicle, strength, limit));
    }
    trial.flight.clear();
    for (std::size_t n = 0; n <= kFitFlights; ++n)
      trial.flight.push_back(fly(truth[n], paths[n], scene.noise, request.seed, index, kAir + 10 * n));
    flown = !lost(trial.flight);
  }
  if (!flown) throw std::runtime_error("trial " + std::to_string(index) + " does not fly");
  trial.answer["vehicle"] = trial.vehicle.name;
  trial.answer["kind"] = setting.kind;
  trial.answer["noise"] = setting.noise;
  trial.answer["effects"] = named;
  return trial;
}

}  // namespace reality
