#include "trial_settings.hpp"

#include <algorithm>
#include <stdexcept>

#include "outside.hpp"

namespace reality {
namespace {

template <class List>
const auto& any_of(const List& list, Rng& rng) {
  return list[static_cast<std::size_t>(rng.below(static_cast<int>(list.size())))];
}

}  // namespace

bool Setting::needs(Need need) const {
  return std::any_of(effects.begin(), effects.end(), [&](const auto& name) { return effect(name).need == need; });
}

Setting draw_setting(const Request& request, Rng& rng) {
  Setting s;
  const double lot = rng.uniform();
  s.kind = request.effect && request.kind != "outside" ? "single" : request.kind;
  if (s.kind == "mixed")
    s.kind = lot < 0.25 ? "clean" : lot < 0.35 ? "scatter" : lot < 0.7 ? "single" : lot < 0.9 ? "pair" : "outside";
  s.large = request.large.value_or(rng.chance(0.4));
  s.noise = request.noise.value_or(rng.chance(0.5) ? 1 : 2);
  if (s.kind == "single") {
    s.effects = {request.effect ? effect(*request.effect).name : any_of(catalogue(), rng).name};
  } else if (s.kind == "pair") {
    s.effects = {any_of(catalogue(), rng).name, any_of(catalogue(), rng).name};
    while (alike(s.effects[0], s.effects[1])) s.effects[1] = any_of(catalogue(), rng).name;
  } else if (s.kind == "outside") {
    s.stranger = request.effect ? *request.effect : any_of(strangers(), rng);
  } else if (s.kind != "clean" && s.kind != "scatter") {
    throw std::invalid_argument("no kind of trial is called '" + s.kind + "'");
  }
  return s;
}

Surroundings draw_surroundings(const Setting& setting, Rng& rng) {
  Surroundings s;
  const bool large = setting.large;
  // one surface at a time is flown close to, unless two are needed
  const double lot = rng.uniform();
  const bool free = !setting.needs(Need::ground) && !setting.needs(Need::ceiling) && !setting.needs(Need::wall);
  if ((free && lot < 0.4) || setting.needs(Need::ground)) s.ground_z_m = 0;
  if ((free && lot > 0.88) || setting.needs(Need::ceiling)) s.ceiling_z_m = large ? 6.0 : 2.0;
  if ((free && lot > 0.76 && lot < 0.88) || setting.needs(Need::wall)) {
    const double heading = rng.uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector2d inward(std::cos(heading), std::sin(heading));
    s.wall = Wall{-(large ? 8.0 : 1.75) * inward, inward};
  }
  return s;
}

void scatter(Truth& t, double size, Rng& rng) {
  const auto share = [&](double tolerance) { return size * tolerance * rng.uniform(-1, 1); };
  const double com = effect("center_of_mass").parameter[0].tolerance[t.nominal.large];
  t.mass_kg *= 1 + 0.5 * share(0.012);
  t.thrust_scale *= 1 + 0.5 * share(0.012);
  for (double& gain : t.rotor_gain) gain *= 1 + 0.15 * share(0.01);
  for (int i = 0; i < 3; ++i) t.com_B_m[i] += 0.45 * share(com);
  for (int i = 0; i < 3; ++i) t.inertia_kgm2[i] *= 1 + 0.6 * share(0.05);
  t.torque_ratio_m *= 1 + 0.35 * share(0.05);
  const double lag = 0.6 * share(0.004);
  t.lag_up_s += lag;
  t.lag_down_s += lag;
}

}  // namespace reality
