// Writes a flight down while it is flown.
#pragma once

#include "gustlab/flight_log.hpp"
#include "simulation/flight.hpp"

namespace gustlab {

// Columns of FORMATS.md §1 with reference and disturbance, then awx, awy, awz: the acceleration that the disturbance
// force alone would give (m/s², W), then the controller's telemetry.
class FlightRecorder {
 public:
  // Reserves all memory that the flight will need. Throws ConfigError where the log would have more than most_log_rows.
  FlightRecorder(const Experiment& experiment, Flight& flight);

  void append(Flight& flight, const Observation& measured, const Reference& reference, const RotorCommand& command);
  FlightLog take();

 private:
  void add(double value) { log_.columns[column_++].values.push_back(value); }
  void add(const Vector3& value);

  FlightLog log_;
  bool truth_;
  std::int64_t ticks_per_row_, tick_ = 0;
  std::size_t rotors_;
  std::size_t column_ = 0;
  std::vector<double> telemetry_;
};

// A log of more rows is not flown (FORMATS.md §7): so many fit into memory, and can be read again.
inline constexpr double most_log_rows = 3e6;
// Before long work: throws the ConfigError that run_logged would throw of it.
void check_log_rows(const Experiment& experiment, const RunSpec& spec);

// A planned run from start to figures, and its log.
struct LoggedRun {
  RunRecord record;
  FlightLog log;
};
LoggedRun run_logged(const Experiment& experiment, const RunSpec& spec, AtInterrupt at_interrupt = AtInterrupt::finish);
// Writes the log of a run; a vehicle that is a file keeps its place relative to it. Throws IoError.
// AtInterrupt::end: ends between two rows by throwing Interrupted, and leaves nothing.
void write_run_log(FlightLog log, const Experiment& experiment, const std::string& csv_path,
                   AtInterrupt at_interrupt = AtInterrupt::finish);

}  // namespace gustlab
