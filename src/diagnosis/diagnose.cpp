#include "diagnosis/diagnose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "config/toml.hpp"
#include "diagnosis/alignment/command_offsets.hpp"
#include "diagnosis/alignment/hold.hpp"
#include "diagnosis/estimation/rotor_speeds.hpp"
#include "diagnosis/hover/quasi_static.hpp"
#include "diagnosis/output/explain.hpp"
#include "diagnosis/output/habit.hpp"
#include "diagnosis/output/next_flight.hpp"
#include "diagnosis/output/residual_effect.hpp"
#include "diagnosis/recording/attitude_check.hpp"
#include "diagnosis/recording/clock_checks.hpp"
#include "diagnosis/recording/command_jitter.hpp"
#include "diagnosis/recording/log_checks.hpp"
#include "diagnosis/recording/log_filters.hpp"
#include "diagnosis/recording/sensor_lateness.hpp"
#include "diagnosis/recording/vehicle_check.hpp"
#include "diagnosis/rollout/verify.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "diagnosis/selection/reference_fit.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/evidence/challenge.hpp"
#include "diagnosis/validation/locate.hpp"
#include "diagnosis/evidence/shadow.hpp"
#include "gustlab/errors.hpp"
#include "vehicle/gaps.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace {


std::string label_of(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }
// rows of a log between two times
FlightLog part_of(const FlightLog& log, double from_s, double to_s) {
  FlightLog part = log;
  const auto first = std::lower_bound(log.time_s.begin(), log.time_s.end(), from_s) - log.time_s.begin();
  const auto last = std::lower_bound(log.time_s.begin(), log.time_s.end(), to_s) - log.time_s.begin();
  part.time_s.assign(log.time_s.begin() + first, log.time_s.begin() + last);
  for (std::size_t c = 0; c < log.columns.size(); ++c)
    part.columns[c].values.assign(log.columns[c].values.begin() + first, log.columns[c].values.begin() + last);
  return part;
}

struct Flights { std::vector<FlightLog> fit, holdout, reference; };

// a log that cannot be read is set aside, and said
std::vector<FlightLog> read_all(const std::vector<std::string>& paths, Diagnosis& out) {
  std::vector<FlightLog> logs;
  for (const std::string& path : paths) {
    try {
      logs.push_back(read_flight_log(path));
    } catch (const DataError& error) {
      out.log_findings.push_back({label_of(path), "*", "inconsistent", 0.0, 0.0, error.what(), true, false});
      out.flights.push_back({label_of(path), "set_aside", 0.0, 0.0});
    }
  }
  return logs;
}

void set_aside(std::vector<FlightLog>& logs, const VehicleModel& vehicle, Diagnosis& out) {
  std::vector<bool> away(logs.size(), false);
  const auto note = [&](const std::vector<LogFinding>& findings, std::size_t i) {
    for (const LogFinding& finding : findings) {
      if (finding.file != label_of(logs[i].path)) continue;
      out.log_findings.push_back(finding);
      away[i] = away[i] || finding.sets_flight_aside;
    }
  };
  const std::vector<LogFinding> copies = check_copies(logs);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    note(copies, i);
    if (!away[i]) note(check_attitude(logs[i], vehicle), i);
    if (!away[i]) note(check_log(logs[i], vehicle), i);
    if (away[i]) out.flights.push_back({label_of(logs[i].path), "set_aside", 0.0, 0.0});
  }
  std::size_t at = 0;
  std::erase_if(logs, [&](const FlightLog&) { return away[at++]; });
}

std::string nothing_usable(const Diagnosis& out) {
  std::string text = "no fit flight is usable:";
  for (const LogFinding& f : out.log_findings)
    if (f.sets_flight_aside) text += fmt::format("\n  {}: {}{}", f.file, f.column == "*" ? "" : f.column + " ", f.says);
  return text;
}

// flights ready for the filter; flight i's commands are read offset[first + i] later
std::vector<FlightData> prepare(const std::vector<FlightLog>& logs, const VehicleModel& vehicle, const ReadingOptions& options,
                                const std::vector<double>& offset = {}, std::size_t first = 0) {
  std::vector<FlightData> flights;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    flights.push_back(prepare_flight(logs[i], vehicle, options));
    if (first + i >= offset.size()) continue;
    flights.back().commands.delay(offset[first + i]);
    flights.back().measured_speed.delay(offset[first + i]);
  }
  return flights;
}

bool is_recorded(const std::vector<FlightLog>& logs, std::initializer_list<const char*> any_of) {
  std::ptrdiff_t seen = 0;
  for (const FlightLog& log : logs)
    for (const char* name : any_of)
      if (const auto* column = log.find(name)) seen += std::count_if(column->begin(), column->end(), [](double v) { return std::isfinite(v); });
  return seen > 100;
}

// a value that ran into its bound: the model is bent to something that it is not
std::string at_its_bound(const Catalogue& catalogue, const Selection& selection) {
  for (const Finding& finding : selection.findings)
    for (const int c : catalogue.groups()[static_cast<std::size_t>(finding.group)].columns) {
      const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
      const double value = selection.value[c];
      if (value == column.nominal || value == 0.0) continue;
      if (value <= column.min || value >= column.max) return catalogue.groups()[static_cast<std::size_t>(finding.group)].label;
    }
  return {};
}

void describe_disturbance(const Selection& selection, const Remainder&, Diagnosis& out) {
  constexpr std::array<const char*, 4> name = {"force_xy", "force_z", "torque_xy", "torque_z"};
  for (std::size_t g = 0; g < disturbance_groups; ++g)
    out.disturbance.push_back({name[g], std::sqrt(selection.noise_nominal.variance[g]),
                               std::sqrt(selection.noise_selected.variance[g]), g < 2 ? "m/s^2" : "rad/s^2",
                               selection.noise_selected.time_s[g]});
}

Air air_of(const Session& session, const NoiseModel& left) {
  const auto calm = reference_floor(session.vehicle());
  const auto rms = [](double twice, double once) { return std::sqrt((2.0 * twice * twice + once * once) / 3.0); };
  return {rms(left.rms(0), left.rms(1)), rms(left.rms(2), left.rms(3)), rms(calm[0], calm[1]), rms(calm[2], calm[3]), {}};
}

// Of the mean velocity error half a second ahead, what a model could take away: all but what the disturbance that nothing explains does
// within that time, whose beginning no model knows, and the noise. Variance of the integral of an Ornstein-Uhlenbeck process: Gillespie,
// Phys. Rev. E 54, 1996, eq. 3.17.
std::optional<double> predictable_share(const NoiseModel& left, double error_mps, double noise_mps) {
  if (!std::isfinite(error_mps) || !(error_mps > 0.0)) return std::nullopt;
  constexpr double ahead_s = 0.5;
  const double mean_of_norm = 2.0 * std::sqrt(2.0 / pi);   // of three equal normal components
  double variance = 0.0;
  for (const std::size_t group : {0, 0, 1}) {
    const double t = left.time_s[group];
    variance += (2.0 * left.variance[group] * t * (ahead_s - t * (1.0 - std::exp(-ahead_s / t))) + left.white[group] * ahead_s) / 3.0;
  }
  const double chance = std::hypot(mean_of_norm * std::sqrt(variance), std::isfinite(noise_mps) ? noise_mps : 0.0);
  return std::max(0.0, 1.0 - chance / error_mps);
}

void plot_residuals(const Session& session, const Selection& selection, Diagnosis& out) {
  const Blocks before = blocks(session, selection.smoothed_nominal), after = blocks(session, selection.smoothed_selected);
  for (const Mismatch& m : out.mismatch) {
    if (!m.significant || m.where.empty()) continue;
    const std::string_view names[] = {"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"};
    const auto channel = std::find(std::begin(names), std::end(names), m.channel) - std::begin(names);
    const auto variable = std::find(before.variable.begin(), before.variable.end(), m.where.front().variable) - before.variable.begin();
    ResidualPlot plot{m.channel, m.unit, m.where.front().variable, {}, {}, {}};
    for (std::size_t b = 0; b < before.wrench.size(); ++b) {
      plot.x.push_back(before.value[b][variable]);
      plot.before.push_back(before.wrench[b][channel]);
      plot.after.push_back(after.wrench[b][channel]);
    }
    out.residuals.push_back(std::move(plot));
  }
}

// forces_only: torques are not told
Diagnosis diagnose_with(const DiagnoseOptions& options, bool forces_only) {
  const auto stage = [&](std::string_view what, double done) {
    if (options.progress) options.progress(what, done);
  };
  stage("reading the flights", 0.0);
  Diagnosis out;
  Flights logs;
  logs.fit = read_all(options.fit, out);
  logs.holdout = read_all(options.holdout, out);
  logs.reference = read_all(options.reference, out);
  if (logs.fit.empty()) throw DataError(out.log_findings.front().says);
  const FlightLog& first = logs.fit.front();
  VehicleModel vehicle = options.vehicle ? read_vehicle(*options.vehicle) : read_vehicle(first.meta.vehicle, first.path);
  out.vehicle = vehicle.name;
  set_aside(logs.fit, vehicle, out);
  set_aside(logs.holdout, vehicle, out);
  set_aside(logs.reference, vehicle, out);
  if (logs.fit.empty()) throw DataError(nothing_usable(out));

  assume_nominal_voltage(vehicle, logs.fit.front());
  if (logs.holdout.empty() && logs.fit.size() > 1) {
    logs.holdout.push_back(std::move(logs.fit.back()));
    logs.fit.pop_back();
    out.notes.push_back(fmt::format("no flight was held out by the user: {} is", label_of(logs.holdout.front().path)));
  }
  if (!is_recorded(logs.fit, {"qw", "wx"})) {
    const std::vector<FlightData> fit = prepare(logs.fit, vehicle, {}), held = prepare(logs.holdout, vehicle, {}), normal = prepare(logs.reference, vehicle, {});
    for (const auto& [role, used] : {std::pair{"reference", &normal}, {"fit", &fit}, {"holdout", &held}})
      for (const FlightData& flight : *used) out.flights.push_back({flight.label, role, flight.duration_s(), 0.0});
    compare_hover(normal, fit, held, vehicle, out);
    out.augmented_toml = augmented_toml(out);
    return out;
  }
  if (logs.holdout.empty()) {
    const auto& time = logs.fit.front().time_s;
    const double cut_s = time.front() + (time.back() - time.front()) * 2.0 / 3.0;
    logs.holdout.push_back(part_of(logs.fit.front(), cut_s, time.back() + 1.0));
    logs.fit.front() = part_of(logs.fit.front(), time.front(), cut_s);
    out.notes.emplace_back("there is one flight only: its last third is held out");
  }

  // logs that were smoothed before they were written tell less than their rate
  ReadingOptions reading;
  reading.forces_only = forces_only;
  for (const FlightLog& log : logs.fit)
    if (motion_filtered(log)) {
      reading.max_rate_hz = 20.0;
      reading.common_filter_s = 0.022;
      out.log_findings.push_back({label_of(log.path), "px…wz", "filtered", log.time_s.front(), log.time_s.back(),
                                  "the recording was low-pass filtered before it was written: all columns are filtered once more alike and read at 20 Hz", false, false});
    }
  const bool attitude = is_recorded(logs.fit, {"qw"});
  if (forces_only) out.notes.emplace_back("the torques are not what the model says, and no pose says why: only forces are judged");
  const bool hold_unknown = std::any_of(logs.fit.begin(), logs.fit.end(), [](const FlightLog& l) { return l.meta.hold == Hold::unknown; });

  stage("checking rotors and clocks", 0.02);
  // rotor order, directions and time offsets are judged at the logs' own rate
  std::vector<FlightData> raw = prepare(logs.fit, vehicle, {}), raw_held = prepare(logs.holdout, vehicle, {});
  if (attitude && !forces_only && reading.common_filter_s == 0.0) reading.late = sensor_lateness(raw);
  for (auto* some : {&raw, &raw_held})
    for (FlightData& flight : *some) flight.late = reading.late;
  for (LogFinding& finding : check_rotors(raw, vehicle)) out.log_findings.push_back(std::move(finding));
  // on another clock than the motion, commands tell forces alone
  if (clocks_apart(raw, vehicle, out.log_findings) | clocks_apart(raw_held, vehicle, out.log_findings)) {
    reading.forces_only = true;
    for (auto* flights : {&logs.fit, &logs.holdout})
      for (FlightLog& log : *flights) log = with_total_thrust(std::move(log), vehicle);
  }
  const std::vector<double> offset = command_offsets(raw, raw_held, vehicle, out.log_findings);
  // jitter of a faster loop: what depends on it would come out too small, and look like other physics
  bool jitters = false;
  for (const FlightData& flight : raw) {
    const double share = hold_unknown ? command_jitter_share(flight) : 0.0;
    if (share < most_command_jitter) continue;
    jitters = true;
    out.log_findings.push_back({flight.label, "u1…uN", "inconsistent", flight.start_s, flight.start_s + flight.duration_s(),
                                fmt::format("{:.0f} % of the commanded torque jitters from sample to sample: commands of a faster loop were "
                                            "sampled, and what the rotors did between is not known; log at the loop's rate", 100.0 * share),
                                false, false});
  }
  if (hold_unknown) {
    reading.linear_hold = linear_is_likelier(vehicle, options.jobs, [&](bool linear) {
      ReadingOptions trial = reading;
      trial.linear_hold = linear;
      return prepare(logs.fit, vehicle, trial);
    });
    out.notes.push_back(fmt::format("the logs do not say how commands are held between samples: {} is the likelier", *reading.linear_hold ? "linear" : "zoh"));
  }
  const ReadingOptions own{.linear_hold = reading.linear_hold, .substep_s = 0.01, .as_recorded = true};
  std::optional<Reference> reference;
  if (!logs.reference.empty()) {
    ReferenceFit normal = fit_reference(prepare(logs.reference, vehicle, reading),
                                        reading.common_filter_s > 0.0 ? prepare(logs.reference, vehicle, own) : std::vector<FlightData>{}, vehicle, options.jobs);
    vehicle = std::move(normal.vehicle);
    out.reference_effects = std::move(normal.effects);
    reference = std::move(normal.known);
    for (const FlightLog& log : logs.reference) out.flights.push_back({label_of(log.path), "reference", log.time_s.back() - log.time_s.front(), 0.0});
  }
  std::vector<FlightData> flights = prepare(logs.fit, vehicle, reading, offset, 0),
                          held = prepare(logs.holdout, vehicle, reading, offset, logs.fit.size());
  for (std::size_t i = 0; i < offset.size(); ++i) {
    const FlightData& flight = i < flights.size() ? flights[i] : held[i - flights.size()];
    out.flights.push_back({flight.label, i < flights.size() ? "fit" : "holdout", flight.duration_s(), offset[i]});
  }

  // one-sample innovations of smoothed logs tell of the smoothing: half a second tells of the vehicle
  std::vector<FlightData> own_rate, held_own_rate;
  if (reading.common_filter_s > 0.0) {
    own_rate = prepare(logs.fit, vehicle, own, offset, 0);
    held_own_rate = prepare(logs.holdout, vehicle, own, offset, logs.fit.size());
  }
  Session session(std::move(flights), vehicle, options.jobs, std::move(own_rate));
  if (reference) session.compare_with(std::move(*reference));
  if (session.catalogue().filter_feigns_lags())
    out.notes.push_back(fmt::format("lags and delays of the rotors that are some {:.0f} ms or less beyond the vehicle file's are not told from those of the filter, "
                                    "which the commands did not pass", 1e3 * filter_feigns_s));
  stage("choosing effects", 0.1);
  Selection selection = select_effects(session, {});
  std::vector<FlightLog> proof;
  for (std::size_t i = 0; i < logs.holdout.size(); ++i)
    proof.push_back(with_later_inputs(logs.holdout[i], offset[logs.fit.size() + i]));
  stage("testing them on other flights", 0.5);
  const Challenge challenged = challenge(session, selection, {held, held_own_rate, proof},
                                         [&] { return std::min(pose_lateness_s(raw), pose_lateness_s(raw_held)); }, options.jobs);
  const Remainder& rest = challenged.rest;
  // moments that depend on the velocity are not told without it, and would be charged to what can be
  if (!attitude && !forces_only && !rest.alarms.empty()) return diagnose_with(options, true);
  out.evidence = challenged.records;
  out.evidence.insert(out.evidence.end(), challenged.withdrawn.begin(), challenged.withdrawn.end());
  explain(session, selection, challenged, out);
  if (std::any_of(out.effects.begin(), out.effects.end(), [&](const EffectFinding& e) { return session.seen_in_speeds(session.catalogue().find(e.effect)); }))
    out.notes.push_back(fmt::format("commands foretell the rotors' speeds to {:.3g} rad/s instead of {:.3g} (rms, held-out flights); measured speeds drive "
                                    "the body's predictions, which that does not change",
                                    speeds_left_radps(held, session.catalogue(), selection.value),
                                    speeds_left_radps(held, session.catalogue(), session.catalogue().nominal())));
  if (rest.names_gust) explain_gust(session, rest.gust, out);
  describe_disturbance(selection, rest, out);
  out.air = air_of(session, selection.noise_selected);
  out.alarms = rest.alarms;
  out.unexplained_share = rest.omnibus_share;
  out.mismatch = locate(session, selection, rest);
  plot_residuals(session, selection, out);

  if (jitters) suspect(out, "only suspected: the commands were sampled from a faster loop");

  stage("flying the model in the simulator", 0.75);
  // proof in the simulator, on flights that were not used
  config::Table found = config::Table::parse(augmented_toml(out), "augmented.toml");
  Verification verified = verify(proof, vehicle, config::read_effects(found), options.jobs);
  out.fit = std::move(verified.fit);
  if (!out.fit.is_null())
    out.air.predictable_share = predictable_share(selection.noise_selected, half_a_second_ahead(out.fit, "velocity_mps", "before"),
                                                  half_a_second_ahead(out.fit, "velocity_mps", "noise"));
  out.window_file = verified.window_file;
  out.window = std::move(verified.window);

  std::vector<int> named;
  for (const EffectFinding& effect : out.effects) named.push_back(session.catalogue().find(effect.effect));
  if (!SubsetSearch(session.catalogue(), vehicle, 0.0).allowed(named))
    suspect(out, "only suspected: without a drag no wind is felt", [](const EffectFinding& effect) { return effect.effect != "steady_wind"; });
  const std::string bound = at_its_bound(session.catalogue(), selection);
  if (!bound.empty()) out.notes.push_back(fmt::format("{} ran into its bound: the model is bent to something that it is not", bound));
  if (jitters) out.verdict = Verdict::insufficient_data;
  else if (out.effects.empty() && !bound.empty()) out.verdict = Verdict::unexplained;
  else if (out.effects.empty()) out.verdict = rest.alarms.empty() ? Verdict::consistent : Verdict::unexplained;
  else if (rest.omnibus_share < 0.1 && std::all_of(rest.alarms.begin(), rest.alarms.end(), [](const Alarm& a) { return a.kind == "omnibus"; }))
    out.verdict = Verdict::explained;
  else out.verdict = Verdict::partly_explained;
  stage("looking for a flight that would tell more", 0.85);
  suggest_flight(session, selection, options.jobs, out);
  if (out.verdict == Verdict::unexplained || out.verdict == Verdict::partly_explained)
    offer_residual(session, selection, proof, options.jobs, out);
  offer_habit(session, proof, options.jobs, out);
  out.augmented_toml = augmented_toml(out);
  return out;
}

}  // namespace

Diagnosis diagnose(const DiagnoseOptions& options) { return diagnose_with(options, false); }

}  // namespace gustlab::diagnosis
