#include "diagnosis/output/explain.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "config/toml.hpp"
#include "diagnosis/evidence/judge.hpp"
#include "diagnosis/output/weak_points.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/found_effects.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/validation/regimes.hpp"

namespace gustlab::diagnosis {

using namespace decisions;

namespace {

std::string catalogue_name(const Group& group) { return std::string(group.row->name); }

// five standard deviations of a number, in typical sizes of it; infinite where no size would show
double size_that_shows(const Eigen::MatrixXd& projected, int column) {
  const double information = projected(column, column);
  return information > 1e-9 ? 5.0 / std::sqrt(information) : std::numeric_limits<double>::infinity();
}

// why a group is hardly identifiable in these flights; no value when it is
std::optional<NotIdentifiable> why_not_identifiable(const Session& session, const Selection& selection, int g) {
  const Group& group = session.catalogue().group(g);
  if (session.catalogue().filter_looks_like_lag() && makes_rotors_late(*group.row) && !selection.find(g))
    return NotIdentifiable{
        catalogue_name(group),
        fmt::format("up to {:.0f} ms beyond the vehicle file's it looks like the filter that these logs passed",
                    1e3 * filter_lag_s),
        Lack::raw_sensors};
  if (session.catalogue().loop_answers() && group.row->latency != Latency::none && !selection.find(g))
    return NotIdentifiable{
        catalogue_name(group),
        "within half a second the recorded loop answers what disturbs the vehicle: how late a torque comes is not told",
        Lack::raw_sensors};
  const Eigen::MatrixXd projected = project_out(selection.grams.total(), session.biases());
  double best = std::numeric_limits<double>::infinity();
  for (const int c : group.columns) best = std::min(best, size_that_shows(projected, c));
  if (!(best > hardly_shown)) return std::nullopt;
  const std::string why = std::isinf(best) ? "these flights do not show it"
                                           : fmt::format("only one {:.0f} times as large as is usual would show", best);
  return NotIdentifiable{catalogue_name(group), why + shows_in_words(group.row->shows_in), Lack::excitation,
                         std::string(group.row->shows_in)};
}

// two significant digits and all before the point: 113, 27, 0.0014
std::string in_digits(double value) {
  const int before = value > 0.0 ? static_cast<int>(std::floor(std::log10(value))) : 1;
  return fmt::format("{:.{}f}", value, std::max(0, 1 - before));
}

// late and lasting: what was taken into account
void describe_sensors(const Session& session, const NoiseModel& noise, Diagnosis& out) {
  const FlightData& flight = session.flights().front();
  for (const auto& [sensor, latency_s] :
       {std::pair{"gyro", flight.late.rate_s}, {"accelerometer", flight.late.force_s}})
    if (latency_s > 0.0)
      out.notes.push_back(
          fmt::format("the {} is {:.1f} ms later than the pose, as a filter makes it: taken into account", sensor,
                      1e3 * latency_s));
  if (flight.late.pose_ahead_s > 0.0)
    out.notes.push_back(fmt::format(
        "positions and attitudes of this simulation are {:.1f} ms ahead of all else, as steps make them that "
        "take velocities first: taken into account",
        1e3 * flight.late.pose_ahead_s));
  if (!noise.errors_last()) return;
  constexpr std::array<std::pair<const char*, const char*>, noise_groups> sensor = {
      {{"position", "mm"}, {"attitude", "mrad"}, {"gyro", "mrad/s"}, {"accelerometer", "mm/s²"}}};
  std::vector<std::string> sizes;
  for (std::size_t g = 0; g < noise_groups; ++g)
    if (noise.lasting_variance[g] > noise.measurement[g])
      sizes.push_back(fmt::format("{} {} {} for {} s", sensor[g].first,
                                  in_digits(1e3 * std::sqrt(noise.lasting_variance[g])), sensor[g].second,
                                  in_digits(noise.lasting_time_s[g])));
  out.notes.push_back(
      fmt::format("errors of the sensors last, as those of an estimator, of interpolated poses or behind a filter: {}; "
                  "taken into account",
                  fmt::join(sizes, ", ")));
}

const Group& group_of(const Session& session, int group) { return session.catalogue().group(group); }

// values of the effect, as changes where there are reference flights, and of every flight's own
void fill_values(const Session& session, const Selection& selection, const Group& group, EffectFinding& effect) {
  const Catalogue& catalogue = session.catalogue();
  effect.parameters = values_of(catalogue, selection, group, -1);
  if (session.reference() && !group.row->is_history()) {
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
}

// Names that these flights do not distinguish from the effect, and whether one of them would be a trim.
bool fill_rivals(const Session& session, const Selection& selection, const Finding& finding, EffectFinding& effect) {
  bool trim = false;
  const bool commanded = group_of(session, finding.group).row->commanded;
  for (const Rival& rival : finding.rivals) {
    const std::string name = catalogue_name(group_of(session, rival.group));
    // or no farther apart than what unpredicted commands explain
    const bool alike = equal(rival, finding);
    const bool equivalent =
        alike || (commanded && rival.delta_chi2 <
                                   std::min(selection.unpredicted_delta_chi2, most_lost_to_rival * finding.delta_chi2));
    effect.confusable.push_back({name, equivalent, rival.z, rival.delta_chi2});
    if (equivalent) effect.classmates.push_back(name);
    trim = trim || (alike && !is_told(rival) && rival.below_tolerance);
  }
  return trim;
}

// a load that hangs is no weight that went
bool may_be(const EffectRow& other, const EffectFinding& effect) {
  const std::unique_ptr<Effect> made = other.make();
  return effect.parameters.empty() || effect.parameters.front().value > 0.0 || numbers_of(*made).front().info.min < 0.0;
}

// Names that no flight, or no such flight or log, distinguishes from the effect.
void fill_aliases(const Session& session, const Selection& selection, int group, EffectFinding& effect) {
  const Catalogue& catalogue = session.catalogue();
  const EffectRow& row = *catalogue.group(group).row;
  // only c_τ k_f / J_z is visible, when J_x and J_y are right
  if (!row.alias.effect.empty()) effect.classmates.emplace_back(row.alias.effect);
  for (const EffectRow& other : effect_registry()) {
    // of a moment of inertia in yaw the same is true the other way round
    if (other.alias.effect == row.name && catalogue.asks_last(group)) {
      const NamedValue& z = effect.parameters.back();
      if (std::abs(z.value) > std::max(least_aliased, equivalent_z * z.deviation))
        effect.classmates.emplace_back(other.name);
    }
    // what these logs do not distinguish from it is not tried
    if (other.stand_in == row.name && catalogue.why_left_out(other) && may_be(other, effect))
      effect.classmates.emplace_back(other.name);
  }
  for (const std::string_view other : row.like_unless_turning)
    if (!other.empty() && headings_are_kept(session) && !selection.find(catalogue.find(other)))
      effect.classmates.emplace_back(other);
}

// Named, suspected, or no missing physics at all; false: none of these.
bool explain_finding(const Session& session, const Selection& selection, const Challenge& challenge, std::size_t i,
                     Diagnosis& out) {
  const Finding& finding = selection.findings[i];
  const Group& group = group_of(session, finding.group);
  EffectFinding effect;
  effect.effect = catalogue_name(group);
  effect.place = to_string(group.row->place);
  effect.says = group.row->says;
  effect.delta_chi2 = finding.delta_chi2;
  effect.price = selection.grams.price(group.columns.size());
  fill_values(session, selection, group, effect);
  effect.classmates = {effect.effect};
  // what may as well be a trim of another name is not missing physics
  bool calibration =
      finding.calibration || (group.row->asks(Need::torque_ratio) && !session.vehicle().torque_ratio_known);
  calibration |= fill_rivals(session, selection, finding, effect);
  fill_aliases(session, selection, finding.group, effect);
  put_in_order(effect);
  effect.confidence = challenge.records[i].probability;
  if (!challenge.regimes[i].empty()) effect.least_even = challenge.regimes[i].front();
  if (!calibration && effect.confidence < suspected_from) return false;
  (calibration ? out.calibration : effect.confidence >= named_from ? out.effects : out.suspected).push_back(effect);
  return true;
}

void note_tilted_frame(const Session& session, Diagnosis& out) {
  if (session.flights().size() < 2) return;
  for (const EffectFinding& effect : out.effects) {
    if (!find_effect(effect.effect)->external) continue;
    const double side_mps2 =
        std::hypot(effect.parameters[0].value, effect.parameters[1].value) / session.vehicle().mass_kg;
    out.notes.push_back(
        fmt::format("a force to the side that is the same in every flight may as well be a position frame that is "
                    "tilted, here by {:.2g}°",
                    std::atan(side_mps2 / session.vehicle().gravity_mps2) * 180.0 / std::numbers::pi));
  }
}

// From which size on numbers would show in these flights.
class Shown {
 public:
  Shown(const Session& session, const Selection& selection)
      : session_(session),
        selection_(selection),
        by_chance_(SubsetSearch(session.catalogue(), session.vehicle(), 0.0).gained_by_chance()),
        total_(selection.grams.total()),
        alone_(project_out(total_, session.biases())) {}

  // The size of every number of a group beside all else that was found but calibration, which it may be itself; of one per flight the flight that shows
  // it best. Left out where no possible size would show.
  std::vector<NamedValue> sizes(int g) const {
    const Group& group = session_.catalogue().group(g);
    std::vector<int> others;
    for (const Finding& finding : selection_.findings)
      if (!finding.calibration && finding.group != g) others.push_back(finding.group);
    const std::vector<int> beside = session_.with_biases(others);
    const Eigen::MatrixXd left = project_out(total_, beside);
    std::vector<NamedValue> sizes;
    for (const int c : group.columns) {
      const Column& column = session_.catalogue().column(c);
      if (!(size_that_shows(alone_, c) < hardly_shown)) continue;
      const double size = shows_from(c, beside, left(c, c), group.columns.size()) * column.natural;
      if (!(size < std::max(column.max - column.nominal, column.nominal - column.min))) continue;
      const auto same = std::ranges::find(sizes, column.name, &NamedValue::name);
      if (same == sizes.end()) sizes.push_back({column.name, column.unit, size, 0.0});
      else same->value = std::min(same->value, size);
    }
    return sizes;
  }

 private:
  // In typical sizes: five standard errors, which disturbances that last make larger, and what pays for all numbers of its group.
  double shows_from(int column, std::vector<int> beside, double information, std::size_t numbers) const {
    beside.push_back(column);
    const Grams& grams = selection_.grams;
    const double variance =
        clustered_covariance(grams, beside, solve(total_, beside).coefficient).bottomRightCorner<1, 1>().value();
    return std::sqrt(
        std::max({25.0 / information, 25.0 * variance, (grams.price(numbers) + by_chance_) / information}));
  }

  const Session& session_;
  const Selection& selection_;
  const double by_chance_;
  const Eigen::MatrixXd total_, alone_;
};

// a wind beside what was found is felt by nothing
bool blows_unfelt(const Session& session, const Selection& selection, int g) {
  std::vector<int> beside = selection.groups();
  beside.push_back(g);
  return group_of(session, g).row->air == Airflow::wind &&
         !SubsetSearch(session.catalogue(), session.vehicle(), 0.0).allowed(beside);
}

// what is not identifiable in these logs, or in these flights
void list_not_identifiable(const Session& session, const Selection& selection, Diagnosis& out) {
  const Catalogue& catalogue = session.catalogue();
  out.torque_told = catalogue.observes(Need::torque);
  for (const EffectRow& row : effect_registry())
    if (const auto lacking = catalogue.why_left_out(row); row.diagnosable && lacking)
      out.not_identifiable.push_back(*lacking);
  std::string last;
  for (int g = 0; g < std::ssize(catalogue.groups()); ++g) {
    const Group& group = catalogue.group(g);
    if (!group.candidate || group.row->name == last) continue;
    last = group.row->name;
    if (catalogue.why_left_out(*group.row)) continue;
    const auto is_said = [&](const std::vector<EffectFinding>& list) {
      return std::ranges::find(list, group.row->name, &EffectFinding::effect) != list.end();
    };
    if (is_said(out.effects) || is_said(out.suspected)) continue;
    if (const auto lacking = why_not_identifiable(session, selection, g)) out.not_identifiable.push_back(*lacking);
  }
}

// What is `unlikely` by its evidence, the best of what was not chosen, and every other effect that these flights would show; each effect, or each
// rotor of it, once. What is not identifiable is said there.
void list_rejected(const Session& session, const Selection& selection, const std::vector<Evidence>& unlikely,
                   Diagnosis& out) {
  constexpr std::size_t best = 5;
  const auto name_of = [&](int g) { return group_of(session, g).row->name; };
  std::set<std::string_view> said, not_identifiable;
  for (const Finding& finding : selection.findings) said.insert(name_of(finding.group));
  for (const NotIdentifiable& unknown : out.not_identifiable) not_identifiable.insert(unknown.effect);
  std::map<int, double> scores(selection.alone.begin(), selection.alone.end());
  const Shown shown(session, selection);
  const auto reject = [&](int g, double score, const std::string& why) {
    const Group& group = group_of(session, g);
    said.insert(group.row->name);
    const bool unfelt = blows_unfelt(session, selection, g);
    out.rejected.push_back(
        {with_rotor(group.row->name, group.rotor), score, why, unfelt ? std::vector<NamedValue>{} : shown.sizes(g)});
  };
  for (const Evidence& record : unlikely) {
    if (not_identifiable.contains(name_of(record.group))) continue;
    const auto added = scores.find(record.group);
    const double score = added == scores.end()
                             ? record.delta_chi2 - selection.grams.price(group_of(session, record.group).columns.size())
                             : added->second;
    const std::string weak = in_one_clause(weak_points(record));
    reject(record.group, score,
           fmt::format("its own evidence makes it {:.0f} % likely{}{}", 100.0 * record.probability,
                       weak.empty() ? "" : ": ", weak));
    scores.erase(record.group);
  }
  std::vector<std::pair<double, int>> others;
  for (const auto& [g, score] : scores)
    if (!not_identifiable.contains(name_of(g))) others.emplace_back(score, g);
  std::stable_sort(others.begin(), others.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto [score, g] = others[i];
    if (i >= best && said.contains(name_of(g))) continue;
    reject(
        g, score,
        blows_unfelt(session, selection, g)
            ? "without a drag, in the vehicle file or among what was found, no wind is felt: a steady one looks like a "
              "constant force"
        : selection.at_bounds.contains(g) ? "its likeliest value is the largest or smallest that is allowed: it was "
                                            "fitted to something that it does not describe"
        : score > 0.0                     ? "makes the predictions too little better to be one more name"
                                          : "does not make the predictions better");
  }
}

}  // namespace

void put_in_order(EffectFinding& effect) {
  std::vector<std::string> ordered = {effect.effect};
  for (const EffectRow& row : effect_registry())
    if (row.name != effect.effect && std::ranges::count(effect.classmates, row.name)) ordered.emplace_back(row.name);
  effect.classmates = std::move(ordered);
}

void class_what_pushes_alike(Diagnosis& out) {
  const auto is_said = [&](std::string_view name) {
    return std::ranges::count(out.effects, name, &EffectFinding::effect) +
               std::ranges::count(out.suspected, name, &EffectFinding::effect) >
           0;
  };
  for (std::vector<EffectFinding>* list : {&out.effects, &out.suspected})
    for (EffectFinding& effect : *list) {
      const std::string_view other = find_effect(effect.effect)->like_but_for_turning;
      if (other.empty() || is_said(other)) continue;
      effect.classmates.emplace_back(other);
      put_in_order(effect);
    }
}

void explain(const Session& session, const Selection& selection, const Challenge& challenge, Diagnosis& out) {
  describe_sensors(session, selection.noise_selected, out);
  out.history = challenge.history;
  out.evidence = challenge.records;
  out.evidence.insert(out.evidence.end(), challenge.withdrawn.begin(), challenge.withdrawn.end());
  for (Evidence& record : out.evidence) record.weak_points = weak_points(record);
  std::vector<Evidence> unlikely = challenge.withdrawn;
  for (std::size_t i = 0; i < selection.findings.size(); ++i)
    if (!explain_finding(session, selection, challenge, i, out)) unlikely.push_back(challenge.records[i]);
  note_tilted_frame(session, out);
  list_not_identifiable(session, selection, out);
  list_rejected(session, selection, unlikely, out);
}

void say_what_channels_show(std::vector<Mismatch>& channels) {
  const auto is_of = [](const Mismatch& m, Place place) {
    return (m.channel == "actuation" && place == Place::actuation) ||
           (m.channel == "timing" && place == Place::measurement);
  };
  for (Mismatch& m : channels)
    for (const EffectRow& row : effect_registry())
      if (row.diagnosable && row.latency != Latency::none && is_of(m, row.place)) m.effects.emplace_back(row.name);
}

void explain_gust(const Session& session, const GustParts& parts, Diagnosis& out) {
  const EffectRow& row =
      first_effect([](const EffectRow& r) { return r.diagnosable && r.column == ColumnFrom::nowhere; });
  const double mass = session.vehicle().mass_kg;
  EffectFinding effect;
  effect.effect = row.name;
  effect.place = to_string(row.place);
  effect.says = row.says;
  effect.classmates = {effect.effect};
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
  effect.delta_chi2 = 0.0;
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
  const auto changed = [&](const std::vector<EffectFinding>& found, const EffectFinding& old) {
    return std::any_of(found.begin(), found.end(),
                       [&](const EffectFinding& e) { return e.effect == old.effect && e.rotor() == old.rotor(); });
  };
  for (const EffectFinding& old : diagnosis.reference_effects)
    if (!changed(diagnosis.effects, old) && !changed(diagnosis.calibration, old)) reference.push_back(old);
  write(reference, "  # in the reference flights");
  write(diagnosis.effects, "");
  write(diagnosis.calibration, "  # calibration, within the usual scatter of a build");
  text += diagnosis.residual_toml;
  return text;
}

}  // namespace gustlab::diagnosis
