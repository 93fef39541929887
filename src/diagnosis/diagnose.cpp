#include "diagnosis/diagnose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "config/toml.hpp"
#include "diagnosis/alignment/align.hpp"
#include "diagnosis/alignment/between_rows.hpp"
#include "diagnosis/estimation/rotor_speeds.hpp"
#include "diagnosis/evidence/challenge.hpp"
#include "diagnosis/evidence/half_rate.hpp"
#include "diagnosis/evidence/reference_fit.hpp"
#include "diagnosis/evidence/suspect.hpp"
#include "diagnosis/evidence/usual_names.hpp"
#include "diagnosis/hover/quasi_static.hpp"
#include "diagnosis/model/speed_comparison.hpp"
#include "diagnosis/output/conclude.hpp"
#include "diagnosis/output/explain.hpp"
#include "diagnosis/output/habit.hpp"
#include "diagnosis/output/next_flight.hpp"
#include "diagnosis/output/residual_effect.hpp"
#include "diagnosis/recording/limit_cycle.hpp"
#include "diagnosis/recording/recordings.hpp"
#include "diagnosis/recording/sensor_latency.hpp"
#include "diagnosis/recording/total_thrust.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/rollout/verify.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/validation/locate.hpp"

namespace gustlab::diagnosis {
namespace {

// the first group with a value that ran into its bound: the model is bent to something that it is not
std::string at_its_bound(const Catalogue& catalogue, const std::vector<Evidence>& records) {
  const auto found =
      std::find_if(records.begin(), records.end(), [](const Evidence& record) { return record.at_bound; });
  return found == records.end() ? std::string() : catalogue.group(found->group).label;
}

std::vector<Disturbance> disturbance_of(const Selection& selection) {
  std::vector<Disturbance> result;
  constexpr std::array<const char*, 4> name = {"force_xy", "force_z", "torque_xy", "torque_z"};
  for (std::size_t g = 0; g < disturbance_groups; ++g)
    result.push_back({name[g], std::sqrt(selection.noise_nominal.variance[g]),
                      std::sqrt(selection.noise_selected.variance[g]), g < 2 ? "m/s^2" : "rad/s^2",
                      selection.noise_selected.time_s[g]});
  return result;
}

Air air_of(const Session& session, const NoiseModel& left) {
  const auto calm = reference_floor(session.vehicle());
  const auto rms = [](double twice, double once) { return std::sqrt((2.0 * twice * twice + once * once) / 3.0); };
  return {
      rms(left.rms(0), left.rms(1)), rms(left.rms(2), left.rms(3)), rms(calm[0], calm[1]), rms(calm[2], calm[3]), {}};
}

// Of the mean velocity error half a second ahead, what a model could take away: all but what the disturbance that nothing explains does
// within that time, whose beginning no model knows, and the noise. Variance of the integral of an Ornstein-Uhlenbeck process: Gillespie,
// Phys. Rev. E 54, 1996, eq. 3.17.
std::optional<double> predictable_share(const NoiseModel& left, double error_mps, double noise_mps) {
  if (!std::isfinite(error_mps) || !(error_mps > 0.0)) return std::nullopt;
  constexpr double ahead_s = 0.5;
  const double mean_of_norm = 2.0 * std::sqrt(2.0 / pi);  // of three equal normal components
  double variance = 0.0;
  for (const std::size_t group : {0, 0, 1}) {
    const double t = left.time_s[group];
    variance += (2.0 * left.variance[group] * t * (ahead_s - t * (1.0 - std::exp(-ahead_s / t))) +
                 left.white[group] * ahead_s) /
                3.0;
  }
  const double chance = std::hypot(mean_of_norm * std::sqrt(variance), std::isfinite(noise_mps) ? noise_mps : 0.0);
  return std::max(0.0, 1.0 - chance / error_mps);
}

std::vector<ResidualPlot> residual_plots(const Session& session, const Selection& selection,
                                         const std::vector<Mismatch>& mismatch) {
  std::vector<ResidualPlot> plots;
  const Blocks before = blocks(session, selection.smoothed_nominal),
               after = blocks(session, selection.smoothed_selected);
  for (const Mismatch& m : mismatch) {
    if (!m.significant || m.where.empty()) continue;
    const std::string_view names[] = {"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"};
    const auto channel = std::find(std::begin(names), std::end(names), m.channel) - std::begin(names);
    const auto variable =
        std::find(before.variable.begin(), before.variable.end(), m.where.front().variable) - before.variable.begin();
    ResidualPlot plot{m.channel, m.unit, m.where.front().variable, {}, {}, {}};
    for (std::size_t b = 0; b < before.wrench.size(); ++b) {
      plot.x.push_back(before.value[b][variable]);
      plot.before.push_back(before.wrench[b][channel]);
      plot.after.push_back(after.wrench[b][channel]);
    }
    plots.push_back(std::move(plot));
  }
  return plots;
}

// Effects that were fitted to the flights and stood the challenge, and what is left beside them.
struct Fitted {
  VehicleModel vehicle;  // as the reference flights have it, where there are any
  std::vector<EffectFinding> reference_effects;
  std::vector<FlightUse> used;
  std::vector<FlightData> holdout;
  std::vector<FlightLog> proof;  // held-out logs with their command offsets taken out
  Session session;
  Selection selection;
  Challenge challenged;
  Reading reading;
};

std::vector<FlightUse> uses_of(const Aligned& aligned, const Prepared& flights) {
  std::vector<FlightUse> uses;
  for (const FlightLog& log : aligned.reference)
    uses.push_back({label_of(log.path), "reference", log.time_s.back() - log.time_s.front(), 0.0});
  std::size_t at = 0;
  for (const FlightData& flight : flights.fit)
    uses.push_back({flight.label, "fit", flight.duration_s(), aligned.offset_s[at++]});
  for (const FlightData& flight : flights.holdout)
    uses.push_back({flight.label, "holdout", flight.duration_s(), aligned.offset_s[at++]});
  return uses;
}

// as the simulator flies it
FlightLog to_be_flown(FlightLog log, const Aligned& aligned) {
  return aligned.reading.total_thrust ? with_total_thrust(std::move(log), aligned.vehicle) : std::move(log);
}

std::vector<FlightLog> proof_flights(const Aligned& aligned) {
  std::vector<FlightLog> proof;
  for (const FlightLog& log : aligned.holdout)
    proof.push_back(to_be_flown(with_later_inputs(log, aligned.offset_s[aligned.fit.size() + proof.size()]), aligned));
  return proof;
}

std::vector<FlightLog> reference_flights(const Aligned& aligned) {
  std::vector<FlightLog> flights;
  for (const FlightLog& log : aligned.reference) flights.push_back(to_be_flown(log, aligned));
  return flights;
}

// says where the work is; which share of it is through nobody knows
void report_progress(const DiagnoseOptions& options, std::string_view stage) {
  if (options.progress) options.progress(stage, {});
}

// estimate, select, challenge, with or beside what the reference flights show; `testing`: what the last of the three is called
Fitted fit_beside(const ReferenceFit* normal, const Aligned& aligned, Reading reading, std::string_view testing,
                  const DiagnoseOptions& options) {
  const int jobs = options.jobs;
  VehicleModel vehicle = normal ? normal->vehicle : aligned.vehicle;
  Prepared flights = prepare(aligned, vehicle, reading);
  std::vector<FlightUse> used = uses_of(aligned, flights);
  Session session(std::move(flights.fit), vehicle, jobs, std::move(flights.fit_own_rate));
  if (normal) session.compare_with(normal->known);
  if (session.catalogue().filter_looks_like_lag())
    reading.remarks.notes.push_back(
        fmt::format("lags and delays of the rotors that are some {:.0f} ms or less beyond the vehicle file's cannot be "
                    "told from the delay of the filter, which smoothed the motion and not the commands",
                    1e3 * decisions::filter_lag_s));
  if (session.catalogue().commands_are_slow())
    reading.remarks.notes.push_back(
        fmt::format("{}: how much torque in roll and pitch the loop added between them is estimated with all else, and "
                    "what roll and pitch alone would show (inertia, damping) is not told",
                    session.flights().front().loop_goes_on
                        ? "the loop sets new commands on the rows of the logs, and goes on between them"
                        : "the commands were logged at a lower rate than the motion"));
  report_progress(options, "choosing effects");
  Selection selection = select_within_bounds(session);
  report_progress(options, testing);
  std::vector<FlightLog> proof = proof_flights(aligned);
  const auto judge = [&](Selection& judged) {
    return challenge(
        session, judged, {flights.holdout, flights.holdout_own_rate, proof},
        [&] { return std::min(most_pose_latency_s(aligned.raw_fit), most_pose_latency_s(aligned.raw_holdout)); }, jobs);
  };
  Challenge challenged = judge(selection);
  say_usual_names(session, selection, challenged, judge);
  return {std::move(vehicle),   normal ? normal->effects : std::vector<EffectFinding>{},
          std::move(used),      std::move(flights.holdout),
          std::move(proof),     std::move(session),
          std::move(selection), std::move(challenged),
          std::move(reading)};
}

// the groups that are named or suspected
std::vector<int> changes(const Fitted& fitted) {
  std::vector<int> groups;
  for (const Finding& finding : fitted.selection.findings)
    if (!finding.calibration) groups.push_back(finding.group);
  return groups;
}

Fitted fit(const Aligned& aligned, bool forces_only, std::string_view testing, const DiagnoseOptions& options) {
  const Reading reading = settle_reading(aligned, forces_only, options.jobs);
  if (aligned.reference.empty()) return fit_beside(nullptr, aligned, reading, testing, options);
  ReferenceFlights reference(prepare(aligned.reference, aligned.vehicle, reading.options),
                             aligned.was_filtered() ? prepare(aligned.reference, aligned.vehicle, reading.own_rate())
                                                    : std::vector<FlightData>{},
                             reference_flights(aligned), aligned.vehicle, options.jobs);
  constexpr int most_times = 3;
  for (int times = 1;; ++times) {
    const ReferenceFit normal = reference.fit();
    Fitted fitted = fit_beside(&normal, aligned, reading, testing, options);
    if (times == most_times || !reference.have(fitted.session.catalogue(), fitted.selection, changes(fitted)))
      return fitted;
  }
}

// Moments that depend on the velocity are not identifiable without a pose, and would be charged to what can be.
bool torques_mislead(const Aligned& aligned, const Fitted& fitted) {
  return !aligned.attitude && !fitted.challenged.rest.alarms.empty();
}

// How well commands predict the measured speeds, nothing where no held-out flight has both. Of commands that were sampled from a faster loop and
// jitter a lag is a better mean, late or not: where they hardly predict the speeds better, a lag and a delay are alike, and where they do not, it is none.
void judge_by_speeds(const Session& session, const Selection& selection, std::vector<FlightData> holdout,
                     Diagnosis& out) {
  for (FlightData& flight : holdout) flight.measured_at_sample = measured_beside_commands(flight);
  const double before_radps = speeds_left_radps(holdout, session.catalogue(), session.catalogue().nominal());
  if (before_radps == 0.0) return;
  const double after_radps = speeds_left_radps(holdout, session.catalogue(), selection.value);
  out.notes.push_back(fmt::format(
      "commands predict the rotors' speeds to {:.3g} rad/s instead of {:.3g} (rms, held-out flights); measured speeds "
      "drive the body's predictions, which that does not change",
      after_radps, before_radps));
  if (after_radps >= before_radps)
    suspect(out, "only suspected: with it commands do not predict the measured speeds of the rotors better",
            [](const EffectFinding& effect) { return !makes_rotors_late(*find_effect(effect.effect)); });
  if (after_radps < decisions::latency_told * before_radps) return;
  for (EffectFinding& effect : out.effects)
    if (makes_rotors_late(*find_effect(effect.effect))) {
      for (const EffectRow& other : effect_registry())
        if (makes_rotors_late(other) && other.diagnosable) effect.classmates.emplace_back(other.name);
      put_in_order(effect);
    }
}

// Names that stand in for what the logs left out between their rows are only suspected. Lags and delays are not asked: commands of every
// other row are later by themselves. Neither is what means of commands that jitter show: they are known half as well by half of them.
void judge_by_half_rate(const Aligned& aligned, const Fitted& fitted, int jobs, Diagnosis& out) {
  const auto asked = [&](const EffectFinding& effect) {
    const EffectRow& row = *find_effect(effect.effect);
    return !makes_rotors_late(row) && !(fitted.session.catalogue().mean_torques_alone() && shifts_torques(row));
  };
  if (std::ranges::none_of(out.effects, asked)) return;
  std::vector<FlightLog> half;
  for (const FlightLog& log : aligned.fit) half.push_back(every_other_row(log));
  Session session(prepare(half, fitted.vehicle, fitted.reading.options, aligned.offset_s), fitted.vehicle, jobs);
  const std::vector<double> changes = changes_at_half_rate(session, fitted.session, fitted.selection);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (std::abs(changes[i]) < decisions::same_at_half_rate) continue;
    const Group& group = fitted.session.catalogue().group(fitted.selection.findings[i].group);
    suspect(
        out,
        fmt::format("only suspected: with every other row of the logs alone its size changes by {:+.0f} %; it may be "
                    "what the logs leave out between their rows",
                    100.0 * changes[i]),
        [&](const EffectFinding& effect) {
          return effect.effect != group.row->name || effect.rotor() != group.rotor || !asked(effect);
        });
  }
}

// A gyroscope that reads less than the attitude turns, where the loop turned the body further between the rows than on them.
void judge_by_turns_between_rows(const Fitted& fitted, Diagnosis& out) {
  if (!fitted.session.flights().front().loop_goes_on) return;
  const double further = turn_between_rows(fitted.session.flights()).share;
  suspect(
      out,
      fmt::format("only suspected: between its rows the loop turned the body {:.2g} % further than the rates on them "
                  "say, as its commands show; a gyroscope that reads so much less looks the same",
                  100.0 * further),
      [further](const EffectFinding& effect) {
        const double delta = effect.parameters.empty() ? 0.0 : effect.parameters.front().value;
        return find_effect(effect.effect)->corrects != Corrects::rate_scale || delta > 0.0 ||
               -delta > decisions::most_of_turns_between_rows * further;
      });
}

// A flight out of control shows that rotors answer late, and nothing else.
void judge_by_control(const Aligned& aligned, Diagnosis& out) {
  const double share = share_at_both_limits(aligned.raw_fit);
  if (share < decisions::most_at_both_limits) return;
  out.notes.push_back(
      fmt::format("the loop runs the rotors from one limit to the other ({:.0f} % of the commands are at the highest, "
                  "and as many at the lowest, or more): the vehicle is out of control, which lags and delays do; "
                  "nothing else is told by such flights",
                  100.0 * share));
  suspect(out, "only suspected: the vehicle is out of control, its rotors run from one limit to the other",
          [](const EffectFinding& effect) { return makes_rotors_late(*find_effect(effect.effect)); });
}

// what was found, and where the simulation and the recordings differ; the session is linearised at the nominal vehicle then
Diagnosis describe(Fitted& fitted) {
  Diagnosis out;
  Session& session = fitted.session;
  const Selection& selection = fitted.selection;
  const Remainder& rest = fitted.challenged.rest;
  out.reference_effects = fitted.reference_effects;
  explain(session, selection, fitted.challenged, out);
  if (std::any_of(out.effects.begin(), out.effects.end(),
                  [&](const EffectFinding& e) { return session.seen_in_speeds(session.catalogue().find(e.effect)); }))
    judge_by_speeds(session, selection, fitted.holdout, out);
  if (rest.names_gust) explain_gust(session, rest.gust, out);
  out.disturbance = disturbance_of(selection);
  out.air = air_of(session, selection.noise_selected);
  out.alarms = rest.alarms;
  out.unexplained_share = rest.omnibus_share;
  out.mismatch = locate(session, selection, rest);
  say_what_channels_show(out.mismatch);
  out.residuals = residual_plots(session, selection, out.mismatch);
  return out;
}

// What the names recover of the held-out error, by rollouts in the simulator.
Verification verify_names(const Diagnosis& named, const std::vector<FlightLog>& proof, const VehicleModel& vehicle,
                          int jobs) {
  config::Table found = config::Table::parse(augmented_toml(named), "augmented.toml");
  return verify(proof, vehicle, config::read_effects(found), jobs);
}

// names that cannot stand without another that is missing
void suspect_unfelt(const Session& session, const VehicleModel& vehicle, Diagnosis& out) {
  std::vector<int> named;
  for (const EffectFinding& effect : out.effects) named.push_back(session.catalogue().find(effect.effect));
  if (!SubsetSearch(session.catalogue(), vehicle, 0.0).allowed(named))
    suspect(out, "only suspected: without a drag no wind is felt",
            [](const EffectFinding& effect) { return find_effect(effect.effect)->air != Airflow::wind; });
}

// what goes before what a diagnosis says already
void say_first(const std::vector<FlightUse>& flights, std::initializer_list<const Remarks*> remarks, Diagnosis& out) {
  std::vector<std::string> notes;
  for (const Remarks* r : remarks) {
    out.log_findings.insert(out.log_findings.end(), r->findings.begin(), r->findings.end());
    notes.insert(notes.end(), r->notes.begin(), r->notes.end());
  }
  out.notes.insert(out.notes.begin(), notes.begin(), notes.end());
  out.flights.insert(out.flights.end(), flights.begin(), flights.end());
}

// without attitude and body rate: the balance of mean commands over hover
Diagnosis diagnose_hover(const Recordings& recordings) {
  Diagnosis out;
  out.vehicle = recordings.vehicle.name;
  say_first(recordings.set_aside, {&recordings.remarks}, out);
  const auto read = [&](const std::vector<FlightLog>& logs, const char* role) {
    std::vector<FlightData> flights = prepare(logs, recordings.vehicle, {});
    for (const FlightData& flight : flights) out.flights.push_back({flight.label, role, flight.duration_s(), 0.0});
    return flights;
  };
  const std::vector<FlightData> normal = read(recordings.reference, "reference"), flown = read(recordings.fit, "fit"),
                                held = read(recordings.holdout, "holdout");
  compare_hover(normal, flown, held, recordings.vehicle, out);
  out.augmented_toml = augmented_toml(out);
  return out;
}

Diagnosis diagnose_motion(Recordings recordings, const DiagnoseOptions& options) {
  const int jobs = options.jobs;
  report_progress(options, "checking rotors and clocks");
  const std::string_view testing = recordings.holdout.empty() ? "testing them on the last third of the flight"
                                                              : "testing them on the held-out flights";
  recordings = with_held_out_part(std::move(recordings));
  Aligned aligned = align(recordings);
  settle_between_rows(aligned);
  Fitted fitted = fit(aligned, false, testing, options);
  if (torques_mislead(aligned, fitted)) fitted = fit(aligned, true, testing, options);

  Diagnosis out = describe(fitted);
  if (aligned.hold_unknown && !aligned.was_filtered()) {
    judge_by_half_rate(aligned, fitted, jobs, out);
    judge_by_turns_between_rows(fitted, out);
    class_what_pushes_alike(out);
  }
  judge_by_control(aligned, out);
  out.vehicle = recordings.vehicle.name;
  say_first(recordings.set_aside, {&recordings.remarks, &aligned.remarks, &fitted.reading.remarks}, out);
  out.flights.insert(out.flights.end(), fitted.used.begin(), fitted.used.end());

  // what only commands show depends on those that were not logged; with a pose their sum, or its mean, is enough
  if (aligned.commands_jitter && !aligned.attitude)
    suspect(out, "only suspected: the commands were sampled from a faster loop",
            [](const EffectFinding& effect) { return !find_effect(effect.effect)->commanded; });

  // a motion that contradicts itself is no force from outside
  if (std::ranges::any_of(out.log_findings, [](const LogFinding& f) {
        return f.kind == "inconsistent" && f.column.find_first_of("pvqwa") == 0;
      }))
    suspect(out, "only suspected: columns of the motion contradict each other",
            [](const EffectFinding& effect) { return !find_effect(effect.effect)->external; });

  report_progress(options, "flying the model in the simulator");
  Verification verified = verify_names(out, fitted.proof, fitted.vehicle, jobs);
  out.fit = std::move(verified.fit);
  if (!out.fit.is_null())
    out.air.predictable_share =
        predictable_share(fitted.selection.noise_selected, half_a_second_ahead(out.fit, "velocity_mps", "before"),
                          half_a_second_ahead(out.fit, "velocity_mps", "noise"));
  out.window_file = std::move(verified.window_file);
  out.window = std::move(verified.window);
  suspect_unfelt(fitted.session, fitted.vehicle, out);
  const std::string bound = at_its_bound(fitted.session.catalogue(), fitted.challenged.records);
  if (!bound.empty())
    out.notes.push_back(fmt::format(
        "{} ended at the largest or smallest value allowed: it was fitted to something that it does not describe",
        bound));
  out.verdict = conclude(out, fitted.challenged.rest, !bound.empty(), aligned.commands_jitter);

  report_progress(options, "looking for a flight that would tell more");
  suggest_flight(fitted.session, fitted.selection, jobs, out);
  if (out.verdict == Verdict::unexplained || out.verdict == Verdict::partly_explained)
    offer_residual(fitted.session, fitted.selection, fitted.proof, jobs, out);
  offer_habit(fitted.session, fitted.proof, jobs, out);
  out.augmented_toml = augmented_toml(out);
  return out;
}

}  // namespace

Diagnosis diagnose(const DiagnoseOptions& options) {
  report_progress(options, "reading the flights");
  Recordings recordings = check(read_recordings(options.fit, options.holdout, options.reference, options.vehicle));
  std::vector<Stretch> stretches = std::move(recordings.stretches);
  Diagnosis out = is_recorded(recordings.fit, {"qw", "wx"}) ? diagnose_motion(std::move(recordings), options)
                                                            : diagnose_hover(recordings);
  out.stretches = std::move(stretches);
  return out;
}

}  // namespace gustlab::diagnosis
