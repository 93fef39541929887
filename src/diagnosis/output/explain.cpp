#include "diagnosis/output/explain.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "config/toml.hpp"
#include "diagnosis/evidence/judge.hpp"
#include "diagnosis/selection/found_effects.hpp"
#include "diagnosis/validation/regimes.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double equivalent_z = 2.6;

// declared exact aliases: what no flight can tell apart, whatever it does
constexpr std::pair<std::string_view, std::string_view> exact_alias[] = {
    {"yaw_torque_ratio", "inertia"},  // only c_τ k_f / J_z is visible, when J_x and J_y are right
};

std::string catalogue_name(const Group& group) { return std::string(group.row->name); }

// why a group can hardly be told from these flights; empty when it can
std::string why_not_told(const Session& session, const Selection& selection, const Group& group) {
  // the strength that five standard deviations would need, against a typical one
  const Eigen::MatrixXd projected = project_out(selection.grams.total(), session.biases());
  double best = 1e300;
  for (const int c : group.columns) {
    const double information = projected(c, c);
    if (information > 1e-9) best = std::min(best, 5.0 / std::sqrt(information));
  }
  if (best > 1e200) return fmt::format("these flights do not excite it (it shows in: {})", group.row->shows_in);
  if (best > 6.0)
    return fmt::format("only a strength {:.0f} times its natural size would show (it shows in: {})", best,
                       group.row->shows_in);
  return {};
}

// late and lasting: what was taken into account
void describe_sensors(const Session& session, const NoiseModel& noise, Diagnosis& out) {
  const FlightData& flight = session.flights().front();
  for (const auto& [sensor, late_s] : {std::pair{"gyro", flight.late.rate_s}, {"accelerometer", flight.late.force_s}})
    if (late_s > 0.0)
      out.notes.push_back(fmt::format(
          "the {} is {:.1f} ms later than the pose, as a filter makes it: taken into account", sensor, 1e3 * late_s));
  if (!noise.errors_last()) return;
  constexpr std::array<std::pair<const char*, const char*>, noise_groups> sensor = {
      {{"position", "mm"}, {"attitude", "mrad"}, {"gyro", "mrad/s"}, {"accelerometer", "mm/s²"}}};
  std::vector<std::string> sizes;
  for (std::size_t g = 0; g < noise_groups; ++g)
    if (noise.lasting_variance[g] > noise.measurement[g])
      sizes.push_back(fmt::format("{} {:.2g} {} for {:.2g} s", sensor[g].first,
                                  1e3 * std::sqrt(noise.lasting_variance[g]), sensor[g].second,
                                  noise.lasting_time_s[g]));
  out.notes.push_back(
      fmt::format("errors of the sensors last, as those of an estimator, of interpolated poses or behind a filter: {}; "
                  "taken into account",
                  fmt::join(sizes, ", ")));
}

}  // namespace

void explain(const Session& session, const Selection& selection, const Challenge& challenge, Diagnosis& out) {
  describe_sensors(session, selection.noise_selected, out);
  const Catalogue& catalogue = session.catalogue();
  const auto group_of = [&](int g) -> const Group& { return catalogue.groups()[static_cast<std::size_t>(g)]; };
  for (std::size_t i = 0; i < selection.findings.size(); ++i) {
    const Finding& finding = selection.findings[i];
    const Group& group = group_of(finding.group);
    EffectFinding effect;
    effect.effect = catalogue_name(group);
    effect.place = to_string(group.row->place);
    effect.says = group.row->says;
    effect.gain = finding.gain;
    effect.parameters = values_of(catalogue, selection, group, -1);
    if (session.reference() && !is_history(group.row->name)) {
      effect.total = effect.parameters;
      Selection nominal;
      nominal.value = catalogue.nominal(), nominal.deviation = Eigen::VectorXd::Zero(catalogue.size());
      const std::vector<NamedValue> before = values_of(catalogue, nominal, group, -1);
      for (std::size_t p = 0; p < before.size(); ++p)
        if (before[p].name == effect.parameters[p].name && before[p].name != "rotor")
          effect.parameters[p].value -= before[p].value;
    }
    if (group.row->per_flight)
      for (std::size_t f = 0; f < session.flights().size(); ++f)
        effect.per_flight.emplace_back(session.flights()[f].label,
                                       values_of(catalogue, selection, group, static_cast<int>(f)));
    effect.classmates = {effect.effect};
    // what may as well be a trim of another name is not missing physics
    bool calibration =
        finding.calibration || (group.row->asks(Need::torque_ratio) && !session.vehicle().torque_ratio_known);
    for (const Rival& rival : finding.rivals) {
      const std::string name = catalogue_name(group_of(rival.group));
      // few blocks may carry a whole effect: a rival that keeps less than half of its gain is no equal, whatever the spread
      const bool equal = rival.z < equivalent_z && rival.delta_score < 0.5 * finding.gain;
      // or no farther apart than what unforetold commands explain
      const bool equivalent = equal || (group.row->commanded &&
                                        rival.delta_score < std::min(selection.unforetold_gain, 0.5 * finding.gain));
      effect.confusable.push_back({name, equivalent, rival.z, rival.delta_score});
      if (equivalent) effect.classmates.push_back(name);
      calibration = calibration || (equal && rival.below_tolerance);
    }
    // of a moment of inertia in yaw the same is true the other way round
    if (effect.effect == "inertia" && !effect.parameters.empty()) {
      const NamedValue& z = effect.parameters.back();
      if (std::abs(z.value) > std::max(0.05, equivalent_z * z.deviation))
        effect.classmates.emplace_back("yaw_torque_ratio");
    }
    for (const auto& [a, b] : exact_alias)
      if (effect.effect == a &&
          std::find(effect.classmates.begin(), effect.classmates.end(), b) == effect.classmates.end())
        effect.classmates.emplace_back(b);
    // what these logs cannot tell from it is not tried
    for (const auto& [tried, left_out] : {std::pair{"thrust_scale", "mass"}, {"constant_force", "steady_wind"}})
      if (effect.effect == tried && !catalogue.why_left_out(*find_effect(left_out)).empty())
        effect.classmates.emplace_back(left_out);
    // what fits best first, the others in catalogue order, each name once
    std::vector<std::string> ordered = {effect.effect};
    for (const EffectRow& row : effect_registry())
      if (row.name != effect.effect &&
          std::find(effect.classmates.begin(), effect.classmates.end(), row.name) != effect.classmates.end())
        ordered.emplace_back(row.name);
    effect.classmates = ordered;
    effect.confidence = challenge.records[i].probability;
    if (!challenge.regimes[i].empty()) effect.least_even = challenge.regimes[i].front();
    (calibration ? out.calibration : effect.confidence >= named_from ? out.effects : out.suspected).push_back(effect);
  }
  for (const EffectFinding& effect : out.effects)
    if (effect.effect == "constant_force" && session.flights().size() > 1) {
      const double side_mps2 =
          std::hypot(effect.parameters[0].value, effect.parameters[1].value) / session.vehicle().mass_kg;
      out.notes.push_back(
          fmt::format("a force to the side that is the same in every flight may as well be a position frame that is "
                      "tilted, here by {:.2g}°",
                      std::atan(side_mps2 / session.vehicle().gravity_mps2) * 180.0 / std::numbers::pi));
    }
  for (const Evidence& record : challenge.withdrawn)
    out.rejected.push_back({record.effect, record.gain,
                            fmt::format("its own evidence gives it a probability of {:.2f}", record.probability)});
  // the best of what was not chosen, and of what was chosen too small to name
  std::vector<std::pair<double, int>> others;
  for (const auto& [g, gain] : selection.alone) others.emplace_back(gain, g);
  std::stable_sort(others.begin(), others.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (std::size_t i = 0; i < std::min<std::size_t>(5, others.size()); ++i) {
    const Group& group = group_of(others[i].second);
    out.rejected.push_back(
        {group.rotor > 0 ? fmt::format("{} (rotor {})", group.row->name, group.rotor) : catalogue_name(group),
         others[i].first, others[i].first > 0.0 ? "gains less than the materiality of a further effect" : "no gain"});
  }
  for (const EffectRow& row : effect_registry())
    if (const std::string why = catalogue.why_left_out(row); row.diagnosable && !why.empty())
      out.not_identifiable.push_back({std::string(row.name), why});
  std::string last;
  for (const Group& group : catalogue.groups()) {
    if (!group.candidate || group.row->name == last) continue;
    last = group.row->name;
    if (!catalogue.why_left_out(*group.row).empty()) continue;
    const std::string why = why_not_told(session, selection, group);
    if (!why.empty()) out.not_identifiable.push_back({last, why});
  }
}

void explain_gust(const Session& session, const GustParts& parts, Diagnosis& out) {
  const EffectRow* row = find_effect("gust");
  const double mass = session.vehicle().mass_kg;
  EffectFinding effect;
  effect.effect = "gust";
  effect.place = to_string(row->place);
  effect.says = row->says;
  effect.classmates = {"gust"};
  // standard error of a variance from as many independent pieces as the flights have correlation times
  double duration_s = 0.0;
  for (const FlightData& flight : session.flights()) duration_s += flight.duration_s();
  const double pieces = std::max(4.0, duration_s / parts.time_s);
  const double sigma = mass * parts.horizontal_mps2, sigma_z = mass * parts.vertical_mps2;
  if (parts.horizontal_mps2 > 0.0)
    effect.parameters = {{"sigma_xy", "N", sigma, sigma / std::sqrt(2.0 * pieces) + model_form * sigma},
                         {"sigma_z", "N", sigma_z, sigma_z / std::sqrt(pieces) + model_form * sigma_z},
                         {"correlation_time", "s", parts.time_s, parts.time_s * std::sqrt(2.0 / pieces)}};
  if (parts.line_mps2 > 0.0) {
    effect.parameters.push_back({"line_amplitude", "N", mass * parts.line_mps2,
                                 mass * std::hypot(parts.line_deviation_mps2, model_form * parts.line_mps2)});
    effect.parameters.push_back({"line_frequency", "rad/s", parts.line_radps, parts.line_deviation_radps});
  }
  effect.confidence = 0.9;
  effect.gain = 0.0;
  out.effects.push_back(effect);
}

std::string augmented_toml(const Diagnosis& diagnosis) {
  std::string text = fmt::format("# vehicle {} with what the diagnosis found; values are totals\n", diagnosis.vehicle);
  const auto write = [&](const std::vector<EffectFinding>& effects, std::string_view remark) {
    for (const EffectFinding& effect : effects) {
      text += fmt::format("\n[[effect]]{}\ntype = \"{}\"\n", remark, effect.effect);
      for (const NamedValue& value : effect.total.empty() ? effect.parameters : effect.total) {
        if (value.name == "rotor") text += fmt::format("rotor = {:.0f}\n", value.value);
        else
          text += fmt::format("{} = {}  # {}, sd {:.2g}\n", value.name, config::shortest(value.value), value.unit,
                              value.deviation);
      }
    }
  };
  // what changed since stands for what the reference flights showed of it
  std::vector<EffectFinding> reference;
  const auto rotor_of = [](const EffectFinding& e) {
    return e.parameters.empty() || e.parameters.front().name != "rotor" ? 0.0 : e.parameters.front().value;
  };
  const auto changed = [&](const std::vector<EffectFinding>& found, const EffectFinding& old) {
    return std::any_of(found.begin(), found.end(),
                       [&](const EffectFinding& e) { return e.effect == old.effect && rotor_of(e) == rotor_of(old); });
  };
  for (const EffectFinding& old : diagnosis.reference_effects)
    if (!changed(diagnosis.effects, old) && !changed(diagnosis.calibration, old)) reference.push_back(old);
  write(reference, "  # in the reference flights");
  write(diagnosis.effects, "");
  write(diagnosis.calibration, "  # calibration, below its reporting tolerance");
  text += diagnosis.residual_toml;
  return text;
}

}  // namespace gustlab::diagnosis
