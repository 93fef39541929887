#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/result/finding_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gustlab::diagnosis {

namespace {

using nlohmann::ordered_json;

// JSON has no infinity and no NaN
ordered_json number(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json values(const std::vector<NamedValue>& named) {
  ordered_json result = ordered_json::object();
  for (const NamedValue& v : named) {
    if (v.name == "rotor") result[v.name] = {{"value", static_cast<int>(v.value)}, {"std", 0}, {"unit", v.unit}};
    else result[v.name] = {{"value", number(v.value)}, {"std", number(v.deviation)}, {"unit", v.unit}};
  }
  return result;
}

ordered_json effects(const std::vector<EffectFinding>& findings) {
  ordered_json result = ordered_json::array();
  for (const EffectFinding& f : findings) {
    ordered_json one = {
        {"effect", f.effect}, {"place", f.place}, {"confidence", number(f.confidence)}, {"says", f.says}};
    one["parameters"] = values(f.parameters);
    if (!f.total.empty()) one["total"] = values(f.total);
    if (!f.per_flight.empty()) {
      one["per_flight"] = ordered_json::object();
      for (const auto& [file, named] : f.per_flight) one["per_flight"][file] = values(named);
    }
    one["class"] = f.classmates;
    one["delta_score"] = number(f.delta_chi2);
    one["confusable_with"] = ordered_json::array();
    for (const ConfusableEffect& c : f.confusable)
      one["confusable_with"].push_back({{"effect", c.effect},
                                        {"equivalent", c.equivalent},
                                        {"z", number(c.z)},
                                        {"delta_score", number(c.delta_chi2)}});
    if (!f.least_even.variable.empty())
      one["least_even"] = {
          {"variable", f.least_even.variable}, {"share", f.least_even.share}, {"std", f.least_even.deviation}};
    result.push_back(one);
  }
  return result;
}

ordered_json records(const std::vector<Evidence>& evidence) {
  ordered_json result = ordered_json::array();
  for (const Evidence& e : evidence) {
    ordered_json one = {{"effect", e.effect},
                        {"probability", number(e.probability)},
                        {"parameters", e.parameters},
                        {"delta_chi2", number(e.delta_chi2)},
                        {"delta_chi2_with_partner", number(e.delta_chi2_with_partner)},
                        {"delta_chi2_alone", number(e.delta_chi2_alone)},
                        {"robust_delta_chi2", number(e.robust_delta_chi2())},
                        {"surrogate_inflation", number(e.surrogates.movable ? e.surrogates.inflation : NAN)},
                        {"surrogate_p", number(e.surrogates.movable ? e.surrogates.p_value : NAN)},
                        {"clustered_inflation", number(e.clustered_inflation)},
                        {"held_out_delta_chi2", number(e.held_out_delta_chi2)},
                        {"held_out_expected", number(e.held_out_expected)},
                        {"flights_for", e.flights_for()},
                        {"flights_against", e.flights_against()},
                        {"spread_flights", number(e.spread_flights)},
                        {"spread_regimes", number(e.spread_regimes)},
                        {"uneven", number(e.uneven)},
                        {"slow_fast", number(e.slow_fast)},
                        {"size_in_tolerances", number(e.size_in_tolerances)},
                        {"inclusion", number(e.inclusion)},
                        {"rival_delta_chi2", number(e.rival_delta_chi2)},
                        {"rival_z", number(e.rival_z)},
                        {"unpredicted_commands", number(e.unpredicted_commands)},
                        {"force_excess", number(e.force_excess)},
                        {"force_excess_std", number(e.force_excess_sd)},
                        {"part_lacking", number(e.part_lacking)},
                        {"sensors_share", number(e.sensors_share)},
                        {"at_bound", e.at_bound},
                        {"undone_share", number(e.undone)},
                        {"outweighed", number(e.outweighed)},
                        {"dwarfed_by", number(e.dwarfed_by)},
                        {"push_over_tilt", number(e.force_over_tilt)},
                        {"lone_latency", e.lone_latency},
                        {"slow_speeds_delta_chi2", number(e.slow_speeds_delta_chi2)},
                        {"between_rows_delta_chi2", number(e.between_rows_delta_chi2)},
                        {"alike", e.alike},
                        {"horizon_s", e.horizon_s},
                        {"recovered", e.recovered},
                        {"recovered_z", e.recovered_z}};
    if (e.rotor > 0) one["rotor"] = e.rotor;
    one["weak_points"] = e.weak_points;
    for (const auto& [name, value] : e.features) one["features"][std::string(name)] = number(value);
    one["flights"] = ordered_json::array();
    for (const FlightShare& f : e.flights)
      one["flights"].push_back(
          {{"file", f.file}, {"held_out", f.held_out}, {"share", number(f.share)}, {"std", number(f.deviation)}});
    result.push_back(one);
  }
  return result;
}

ordered_json history_of(const std::vector<JudgedSet>& history) {
  ordered_json result = ordered_json::array();
  for (const JudgedSet& set : history) {
    ordered_json one = {{"names", ordered_json::array()}};
    for (const JudgedSet::Name& name : set.names) {
      one["names"].push_back({{"effect", name.effect}, {"probability", number(name.probability)}});
      if (name.rotor > 0) one["names"].back()["rotor"] = name.rotor;
    }
    one["minus_two_log_likelihood"] = number(set.minus_two_log_likelihood);
    one["withdrawn"] = set.withdrawn;
    if (!set.in_its_place.empty()) one["in_its_place"] = set.in_its_place;
    one["answer"] = set.answer;
    result.push_back(one);
  }
  return result;
}

}  // namespace

namespace {
constexpr std::string_view lacks[] = {"other",     "vehicle_file", "surroundings", "raw_sensors", "attitude_and_rate",
                                      "attitude",  "body_rate",    "motion",       "torque",      "accelerometer",
                                      "excitation"};
}

std::string_view to_string(Lack lack) { return lacks[static_cast<std::size_t>(lack)]; }

Lack lack_named(std::string_view name) {
  const auto* found = std::find(std::begin(lacks), std::end(lacks), name);
  return found == std::end(lacks) ? Lack::other : static_cast<Lack>(found - std::begin(lacks));
}

std::string with_rotor(std::string_view effect, int rotor) {
  return rotor > 0 ? fmt::format("{} (rotor {})", effect, rotor) : std::string(effect);
}

std::string shows_in_words(std::string_view shows_in) { return fmt::format(" (it shows in: {})", shows_in); }

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::consistent:
      return "consistent";
    case Verdict::explained:
      return "explained";
    case Verdict::partly_explained:
      return "partly_explained";
    case Verdict::unexplained:
      return "unexplained";
    case Verdict::insufficient_data:
      return "insufficient_data";
  }
  return "?";
}

ordered_json to_json(const Diagnosis& d) {
  ordered_json out = {{"format", "gustlab-diagnosis/1"}, {"verdict", to_string(d.verdict)}, {"vehicle", d.vehicle}};
  out["flights"] = ordered_json::array();
  for (const FlightUse& f : d.flights)
    out["flights"].push_back(
        {{"file", f.file}, {"role", f.role}, {"duration_s", f.duration_s}, {"time_offset_s", f.time_offset_s}});
  for (const Stretch& s : d.stretches)
    out["stretches"].push_back({{"flight", s.flight}, {"file", s.file}, {"from_s", s.from_s}, {"to_s", s.to_s}});
  out["mismatch"] = ordered_json::array();
  for (const Mismatch& m : d.mismatch) {
    ordered_json where = ordered_json::array();
    for (const Region& r : m.where)
      where.push_back({{"variable", r.variable}, {"above", number(r.above)}, {"share", number(r.share)}});
    out["mismatch"].push_back({{"channel", m.channel},
                               {"significant", m.significant},
                               {"p_value", number(m.p_value)},
                               {"rms", number(m.rms)},
                               {"noise_rms", number(m.noise_rms)},
                               {"unit", m.unit},
                               {"where", where}});
    if (!m.effects.empty()) out["mismatch"].back()["effects"] = m.effects;
  }
  out["effects"] = effects(d.effects);
  if (!d.reference_effects.empty()) out["reference_effects"] = effects(d.reference_effects);
  out["suspected"] = effects(d.suspected);
  out["calibration"] = effects(d.calibration);
  if (!d.residual_model.is_null()) out["residual_model"] = d.residual_model;
  if (!d.habit.is_null()) out["habit"] = d.habit;
  out["evidence"] = records(d.evidence);
  out["history"] = history_of(d.history);
  out["disturbance"] = ordered_json::array();
  for (const Disturbance& g : d.disturbance)
    out["disturbance"].push_back({{"group", g.group},
                                  {"before", number(g.before)},
                                  {"after", number(g.after)},
                                  {"unit", g.unit},
                                  {"correlation_time_s", number(g.correlation_time_s)}});
  out["air"] = {{"force_mps2", number(d.air.force_mps2)},
                {"torque_radps2", number(d.air.torque_radps2)},
                {"calm_force_mps2", number(d.air.calm_force_mps2)},
                {"calm_torque_radps2", number(d.air.calm_torque_radps2)},
                {"predictable_share", number(d.air.predictable_share.value_or(NAN))}};
  out["log_findings"] = ordered_json::array();
  for (const LogFinding& f : d.log_findings)
    out["log_findings"].push_back({{"file", f.file},
                                   {"column", f.column},
                                   {"kind", f.kind},
                                   {"from_s", f.from_s},
                                   {"to_s", f.to_s},
                                   {"says", f.says}});
  out["log_findings_in_short"] = ordered_json::array();
  for (const auto& [kind, says] : finding_lines(d.log_findings, d.flights.size()))
    out["log_findings_in_short"].push_back({{"kind", kind}, {"says", says}});
  out["rejected"] = ordered_json::array();
  for (const Rejected& r : d.rejected) {
    out["rejected"].push_back({{"effect", r.effect}, {"delta_score", number(r.score)}, {"why", r.why}});
    for (const NamedValue& v : r.would_show)
      out["rejected"].back()["would_show"][v.name] = {{"value", number(v.value)}, {"unit", v.unit}};
  }
  out["not_identifiable"] = ordered_json::array();
  for (const NotIdentifiable& n : d.not_identifiable) {
    ordered_json entry = {{"effect", n.effect}, {"why", n.why}};
    if (n.lack != Lack::other) entry["lack"] = to_string(n.lack);
    if (!n.shows_in.empty()) entry["shows_in"] = n.shows_in;
    out["not_identifiable"].push_back(entry);
  }
  out["torque_told"] = d.torque_told;
  out["alarms"] = ordered_json::array();
  for (const Alarm& a : d.alarms) {
    out["alarms"].push_back({{"kind", a.kind}, {"says", a.says}, {"size", number(a.size)}, {"channels", a.channels}});
    if (!a.sensor.empty()) out["alarms"].back()["sensor"] = a.sensor;
  }
  out["unexplained_share"] = number(d.unexplained_share);
  out["notes"] = d.notes;
  out["fit"] = d.fit;
  if (!d.next_trajectory.empty()) {
    out["next_flight"] = {{"trajectory", d.next_trajectory}, {"why", d.next_why}};
    // numbers, lists of numbers and plain texts are the same in TOML and JSON
    for (const auto& [name, literal] : d.next_parameters)
      out["next_flight"]["parameters"][name] = ordered_json::parse(literal);
  }
  out["augmented_model"] = "augmented.toml";
  return out;
}

}  // namespace gustlab::diagnosis
