#include "diagnosis/alignment/align.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "diagnosis/alignment/between_rows.hpp"
#include "diagnosis/alignment/command_offsets.hpp"
#include "diagnosis/alignment/hold.hpp"
#include "diagnosis/recording/clock_checks.hpp"
#include "diagnosis/recording/command_jitter.hpp"
#include "diagnosis/recording/log_filters.hpp"
#include "diagnosis/recording/sensor_latency.hpp"
#include "diagnosis/recording/vehicle_check.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

// logs that were smoothed before they were written hold less than their rate
constexpr double filtered_rate_hz = 20.0, common_filter_s = 0.022;
// What a loop answers within a few milliseconds, and vibration, are no disturbance of the filter's kind: it reads fast logs at this rate.
constexpr double coarse_rate_hz = 130.0;

ReadingOptions reading_of(const std::vector<FlightLog>& logs, std::vector<LogFinding>& findings) {
  ReadingOptions reading;
  reading.coarse_rate_hz = coarse_rate_hz;
  for (const FlightLog& log : logs) {
    if (!motion_filtered(log)) continue;
    reading.max_rate_hz = filtered_rate_hz;
    reading.coarse_rate_hz = 0.0;
    reading.common_filter_s = common_filter_s;
    findings.push_back({label_of(log.path), "px…wz", "filtered", log.time_s.front(), log.time_s.back(),
                        "the recording was low-pass filtered before it was written: all columns are filtered once more "
                        "alike and read at 20 Hz (if it is a simulation, say so: source in the sidecar)",
                        false, false});
  }
  return reading;
}

// commands give forces, and torques over a while
void keep_slow_torques(Aligned& aligned) {
  aligned.reading.forces_only = true;
  aligned.reading.total_thrust = true;
}

// What depends on commands of a faster loop would come out too small, and look like other physics. All flights are fitted together, and so
// one that hardly manoeuvres does no harm beside others.
bool find_jitter(const std::vector<FlightData>& flights, std::vector<LogFinding>& findings) {
  std::vector<const FlightData*> all;
  for (const FlightData& flight : flights) all.push_back(&flight);
  if (command_jitter_share(all) < decisions::most_command_jitter) return false;
  for (const FlightData& flight : flights) {
    const double share = command_jitter_share({&flight});
    if (share < decisions::most_command_jitter) continue;
    findings.push_back(
        {flight.label, "u1…uN", "inconsistent", flight.start_s, flight.start_s + flight.duration_s(),
         fmt::format("{:.0f} % of the commanded torque jitters from sample to sample: commands of a faster loop were "
                     "sampled, and what the rotors did between is not known; log at the loop's rate",
                     100.0 * share),
         false, false});
  }
  return true;
}

// Of recordings a filter's; a simulation has its own (sensor_latency.hpp), where what its loop does between rows must not be taken for it.
SensorLatency latency_of(const Aligned& aligned) {
  const auto simulated = [](const FlightLog& log) { return log.meta.source == "simulation"; };
  if (!std::ranges::all_of(aligned.fit, simulated)) return sensor_latency(aligned.raw_fit);
  std::vector<std::vector<Vector3>> further;
  for (const FlightData& flight : aligned.raw_fit) further.push_back(further_turns(flight));
  const SensorLatency late = sensor_latency(aligned.raw_fit, further);
  ReadingOptions as_recorded;
  as_recorded.as_recorded = true;
  const bool stepped =
      late.rate_s > 0.0 && steps_velocities_first(prepare(aligned.fit, aligned.vehicle, as_recorded), late.rate_s);
  return stepped ? SensorLatency{.pose_ahead_s = late.rate_s} : late;
}

std::vector<FlightLog> marked(std::vector<FlightLog> logs, BetweenRows as) {
  for (FlightLog& log : logs) log.meta.between_rows = as;
  return logs;
}

BetweenRows found_between_rows(const Aligned& aligned) {
  if (!aligned.hold_unknown) return speeds_follow(aligned.raw_fit) ? BetweenRows::as_answered : BetweenRows::as_said;
  if (std::ranges::none_of(aligned.raw_fit, [](const FlightData& f) { return !f.measured_speed.empty(); })) {
    const TurnBetweenRows turn = turn_between_rows(aligned.raw_fit);
    const bool goes_on =
        turn.share > std::max(decisions::least_turn_between_rows, decisions::turn_between_rows_errors * turn.std);
    return goes_on ? BetweenRows::loop_goes_on : BetweenRows::as_said;
  }
  // rotors that are slow, as the vehicle file says, do not jump
  if (rotors_are_late(aligned.vehicle)) return BetweenRows::as_said;
  const auto read = [&aligned](bool jump) {
    const BetweenRows as = jump ? BetweenRows::from_command_to_speed : BetweenRows::as_said;
    return prepare(marked(aligned.fit, as), aligned.vehicle, aligned.reading, aligned.offset_s);
  };
  return speeds_jump(read) ? BetweenRows::from_command_to_speed : BetweenRows::as_said;
}

}  // namespace

Aligned align(const Recordings& recordings) {
  Aligned out;
  std::vector<LogFinding>& findings = out.remarks.findings;
  out.vehicle = recordings.vehicle;
  out.fit = recordings.fit;
  out.holdout = recordings.holdout;
  out.reference = recordings.reference;
  out.reading = reading_of(out.fit, findings);
  out.attitude = is_recorded(out.fit, {"qw"});
  out.hold_unknown =
      std::any_of(out.fit.begin(), out.fit.end(), [](const FlightLog& l) { return l.meta.hold == Hold::unknown; });

  // rotor order, directions and time offsets are judged at the logs' own rate
  out.raw_fit = prepare(out.fit, out.vehicle, {});
  ReadingOptions own_rate;
  if (out.attitude && !out.was_filtered()) own_rate.late = out.reading.late = latency_of(out);
  for (FlightData& flight : out.raw_fit) flight.late = own_rate.late;
  if (own_rate.late.pose_ahead_s > 0.0) out.raw_fit = prepare(out.fit, out.vehicle, own_rate);
  const std::vector<LogFinding> rotors = check_rotors(out.raw_fit, out.vehicle);
  findings.insert(findings.end(), rotors.begin(), rotors.end());
  // what follows is judged with the rotors where they are
  if (!rotors.empty()) out.raw_fit = prepare(out.fit, out.vehicle, own_rate);
  out.raw_holdout = prepare(out.holdout, out.vehicle, own_rate);

  // on another clock than the motion, commands give forces and what lasts
  const std::vector<LogFinding>& of_logs = recordings.remarks.findings;
  const bool fit_apart = clocks_apart(out.raw_fit, out.vehicle, of_logs, findings),
             holdout_apart = clocks_apart(out.raw_holdout, out.vehicle, of_logs, findings);
  if (fit_apart || holdout_apart) keep_slow_torques(out);
  out.offset_s = command_offsets(out.raw_fit, out.raw_holdout, out.vehicle, findings);
  out.commands_jitter = out.hold_unknown && find_jitter(out.raw_fit, findings);
  if (out.commands_jitter && out.attitude) {
    keep_slow_torques(out);
    out.remarks.notes.emplace_back(
        "the commanded torques are not known between samples: only forces, and torques over two seconds, are judged");
  }
  return out;
}

void settle_between_rows(Aligned& aligned) {
  if (aligned.was_filtered() || aligned.reading.forces_only) return;
  const BetweenRows found = found_between_rows(aligned);
  for (std::vector<FlightLog>* logs : {&aligned.fit, &aligned.holdout, &aligned.reference})
    *logs = marked(std::move(*logs), found);
  if (found == BetweenRows::from_command_to_speed)
    aligned.remarks.notes.emplace_back(
        "measured rotor speeds are those before the commands of their rows, which the rotors obey at once: between "
        "rows they go from the command to what the next row measures");
}

Reading settle_reading(const Aligned& aligned, bool forces_only, int jobs) {
  Reading out{aligned.reading, {}};
  out.options.forces_only = out.options.forces_only || forces_only;
  if (forces_only)
    out.remarks.notes.emplace_back(
        "the torques are not what the model says, and no pose says why: only forces are judged");
  if (!aligned.hold_unknown) return out;
  out.options.linear_hold = linear_is_likelier(aligned.vehicle, jobs, [&](bool linear) {
    ReadingOptions trial = out.options;
    trial.linear_hold = linear;
    return prepare(aligned.fit, aligned.vehicle, trial);
  });
  out.remarks.notes.push_back(
      fmt::format("the logs do not say how commands go on between samples (hold in the sidecar): {} fits better",
                  *out.options.linear_hold ? "a straight line from one to the next" : "each until the next comes"));
  return out;
}

Prepared prepare(const Aligned& aligned, const VehicleModel& vehicle, const Reading& reading) {
  Prepared out;
  const auto read = [&](const ReadingOptions& how, std::vector<FlightData>& fit, std::vector<FlightData>& holdout) {
    fit = prepare(aligned.fit, vehicle, how, aligned.offset_s, 0);
    holdout = prepare(aligned.holdout, vehicle, how, aligned.offset_s, aligned.fit.size());
  };
  read(reading.options, out.fit, out.holdout);
  // one-sample innovations of smoothed logs say more of the smoothing, half a second ahead of the vehicle
  if (aligned.was_filtered()) read(reading.own_rate(), out.fit_own_rate, out.holdout_own_rate);
  return out;
}

}  // namespace gustlab::diagnosis
