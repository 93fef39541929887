// Proof on flights that were not used: open-loop rollouts in MuJoCo, before and after.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "diagnosis/result/diagnosis.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

struct Verification {
  nlohmann::ordered_json fit;  // FORMATS.md §4; null when no window could be flown
  double recovered = 1.0;      // of what could be recovered at half a second, mean over quantities
  std::string window_file;
  std::vector<WindowTrace> window;
};

// `found`: all that acts after the diagnosis; values per flight are fitted to what came before each window. Logs: with their
// command offsets taken out.
Verification verify(const std::vector<FlightLog>& holdout, const VehicleModel& vehicle,
                    const std::vector<EffectSpec>& found, int jobs);

// A mean error of a `fit` block at its second horizon, half a second; NaN when there is none. `kind`: hold, before, after, noise.
double half_a_second_ahead(const nlohmann::ordered_json& fit, std::string_view quantity, const char* kind);

// The log with its actuator inputs read some time later.
FlightLog with_later_inputs(const FlightLog& log, double by_s);

}  // namespace gustlab::diagnosis
