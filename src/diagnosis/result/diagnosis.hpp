// All that a diagnosis says, as the report, diagnosis.json and augmented.toml show it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/result/evidence.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

// One quantity of one held-out window, predicted anew from the recorded state every half second. NaN breaks a line.
struct WindowTrace {
  std::string name, unit;
  std::vector<double> time_s, measured, before, after;  // on the log's own clock
};

// What one flight contributed.
struct FlightUse {
  std::string file, role;  // fit | holdout | reference | set_aside
  double duration_s = 0.0, time_offset_s = 0.0;
};

// A flight that is a part of a log which is too long to be diagnosed whole.
struct Stretch {
  std::string flight, file;
  double from_s = 0.0, to_s = 0.0;
};

// A channel of the unexplained wrench against the variable that it depends on most, per half second, before and after.
struct ResidualPlot {
  std::string channel, unit, variable;
  std::vector<double> x, before, after;
};

// What nothing explains of the disturbance in the fit flights (rms), beside what a calm room does to this vehicle.
struct Air {
  double force_mps2 = 0.0, torque_radps2 = 0.0, calm_force_mps2 = 0.0, calm_torque_radps2 = 0.0;
  std::optional<double>
      predictable_share;  // of the held-out velocity error half a second ahead; nothing without a rollout
};

struct Diagnosis {
  Verdict verdict = Verdict::insufficient_data;
  std::string vehicle;
  std::vector<FlightUse> flights;
  std::vector<Stretch> stretches;  // empty: all logs are diagnosed whole
  std::vector<Mismatch> mismatch;
  std::vector<EffectFinding> effects;
  std::vector<EffectFinding> reference_effects;  // what the reference flights show against the vehicle file
  std::vector<EffectFinding> suspected;          // more likely than not, and not proved
  std::vector<Evidence> evidence;                // of every candidate that was judged
  std::vector<JudgedSet> history;                // the sets in which they were judged, in that order
  std::vector<EffectFinding> calibration;        // below their reporting tolerance
  std::vector<Disturbance> disturbance;
  Air air;
  std::vector<LogFinding> log_findings;
  std::vector<Rejected> rejected;
  std::vector<NotIdentifiable> not_identifiable;
  bool torque_told = true;  // false: only forces were judged
  std::vector<Alarm> alarms;
  double unexplained_share = 0.0;  // of all structure, what a generic test still finds
  std::vector<std::string> notes;
  std::string next_trajectory, next_why;
  std::vector<std::pair<std::string, std::string>> next_parameters;  // of the trajectory, TOML literals
  nlohmann::ordered_json residual_model;                             // what is offered for the rest; null: nothing
  std::string residual_toml;                                         // the same as an [[effect]], and the habit's
  nlohmann::ordered_json habit;  // of the loop that was recorded, see habit.hpp; null: none is needed
  std::string augmented_toml;
  // for the page: one held-out window, and unexplained forces against what they depend on
  std::string window_file;
  std::vector<WindowTrace> window;
  std::vector<ResidualPlot> residuals;
  nlohmann::ordered_json fit;  // FORMATS.md §4
};

nlohmann::ordered_json to_json(const Diagnosis& diagnosis);

}  // namespace gustlab::diagnosis
