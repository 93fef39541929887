// Flights on one clock: how their logs are to be read, and how much later the commands of each.
#pragma once

#include <vector>

#include "diagnosis/recording/recordings.hpp"

namespace gustlab::diagnosis {

struct Aligned {
  VehicleModel vehicle;  // with the order and the directions of rotors that the flights show
  std::vector<FlightLog> fit, holdout, reference;
  std::vector<FlightData> raw_fit, raw_holdout;  // at the logs' own rate
  ReadingOptions reading;
  std::vector<double> offset_s;  // by which commands are read later: flights to fit, then those held out
  bool attitude = false;         // is recorded
  bool hold_unknown = false;     // how commands are held between samples
  bool commands_jitter = false;  // they were sampled from a faster loop
  Remarks remarks;

  bool was_filtered() const { return reading.common_filter_s > 0.0; }
};
// Throws DataError when inputs cannot be mapped by the vehicle.
Aligned align(const Recordings& recordings);
// Marks the logs with what their rotors do between rows, where they do not say it.
void settle_between_rows(Aligned& aligned);

// How the flights are read for the filter.
struct Reading {
  ReadingOptions options;
  Remarks remarks;

  // for predictions half a second ahead of logs that were filtered
  ReadingOptions own_rate() const {
    return {.linear_hold = options.linear_hold, .substep_s = 0.01, .as_recorded = true};
  }
};
// `forces_only`: torques are not judged.
Reading settle_reading(const Aligned& aligned, bool forces_only, int jobs);

// Flights as the filter takes them.
struct Prepared {
  std::vector<FlightData> fit, holdout;
  // as they were logged, where they were filtered before; else empty
  std::vector<FlightData> fit_own_rate, holdout_own_rate;
};
Prepared prepare(const Aligned& aligned, const VehicleModel& vehicle, const Reading& reading);

}  // namespace gustlab::diagnosis
