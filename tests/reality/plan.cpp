#include "plan.hpp"

#include <algorithm>
#include <cmath>

namespace reality {
namespace {

using Direction = std::map<std::string, double>;

Direction lag_direction(Rng& rng) {
  const double up = rng.uniform(0.6, 1.0), down = rng.chance(0.6) ? up : rng.uniform(0.6, 1.0);
  const double side = rng.chance(0.75) ? 1 : -1;
  return {{"time_constant", side * up}, {"time_constant_down", side * down}};
}

Direction gust_direction(Plan& plan, Rng& rng) {
  Direction d;
  const double lot = rng.uniform();
  if (lot < 0.75) {
    d["sigma_xy"] = 1;
    d["sigma_z"] = rng.uniform(0.2, 0.6);
    plan.fixed["correlation_time"] = rng.uniform(0.5, 3.0);
  }
  if (lot > 0.45) {
    d["line_amplitude"] = rng.uniform(0.5, 1.0);
    plan.fixed["line_frequency"] = 2 * std::numbers::pi * rng.log_uniform(0.15, 0.8);
  }
  return d;
}

Direction any_direction(const Effect& e, double size, Rng& rng) {
  Direction d;
  double norm = 0;
  for (const Parameter& p : e.parameter) {
    const double x = e.parameter.size() == 1 ? 1 : rng.normal();
    d[p.name] = x;
    norm += x * x;
  }
  const double side = e.both_signs ? rng.sign() : 1;
  for (auto& [key, value] : d) value *= side * size / std::sqrt(norm);
  return d;
}

}  // namespace

Plan draw_plan(const std::string& name, const Nominal& nominal, bool voltage_logged, std::size_t flights, Rng& rng) {
  const Effect& e = effect(name);
  Plan plan;
  plan.effect = name;
  for (std::size_t n = 0; n < (e.whole_vehicle ? 1 : flights); ++n) {
    if (name == "battery_sag") plan.direction.push_back({{voltage_logged ? "exponent" : "rate", 1.0}});
    else if (name == "motor_lag") plan.direction.push_back(lag_direction(rng));
    else if (name == "gust") plan.direction.push_back(gust_direction(plan, rng));
    else if (name == "quadratic_drag")
      plan.direction.push_back({{"area_xy", rng.uniform(0.6, 1.0)}, {"area_z", rng.uniform(0.4, 1.2)}});
    else plan.direction.push_back(any_direction(e, e.whole_vehicle ? 1 : rng.uniform(0.7, 1.2), rng));
  }
  if (name == "rotor_loss") plan.fixed["rotor"] = 1 + rng.below(kRotors);
  if (name == "slung_load") plan.fixed["length"] = nominal.large ? rng.uniform(0.5, 2.0) : rng.uniform(0.15, 0.5);
  return plan;
}

Values values_at(const Plan& plan, const Nominal& nominal, double strength, std::size_t flight) {
  Values values = plan.fixed;
  const auto& direction = plan.direction.size() == 1 ? plan.direction.front() : plan.direction[flight];
  for (const Parameter& p : effect(plan.effect).parameter)
    if (const auto it = direction.find(p.name); it != direction.end())
      values[p.name] = nominal_value(nominal, plan.effect, p.name) +
                       (plan.effect == "saturation" ? -1 : 1) * strength * it->second * p.natural[nominal.large];
  return values;
}

double most_strength(const Plan& plan, const Nominal& nominal) {
  const Effect& e = effect(plan.effect);
  double most = e.most;
  if (plan.effect != "motor_lag") return most;
  // a lag that is shorter than believed stays a lag
  for (const auto& [name, share] : plan.direction.front())
    if (share < 0) most = std::min(most, 0.7 * nominal.motor_lag_s / (-share * e.parameter[0].natural[nominal.large]));
  return most;
}

bool alike(const std::string& a, const std::string& b) {
  static const std::vector<std::pair<std::string, std::string>> same{
      {"mass", "thrust_scale"},        {"mass", "constant_force"},        {"mass", "slung_load"},
      {"thrust_scale", "battery_sag"}, {"attitude_offset", "rotor_tilt"}, {"inertia", "yaw_torque_ratio"}};
  return a == b || std::any_of(same.begin(), same.end(), [&](const auto& pair) {
           return (pair.first == a && pair.second == b) || (pair.first == b && pair.second == a);
         });
}

}  // namespace reality
