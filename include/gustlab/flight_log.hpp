// A flight as columns on one time base: what the recorder writes and every reader returns (FORMATS.md §1).
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gustlab/vehicle.hpp"

namespace gustlab {

enum class ActuatorKind { rotor_speed, thrust, throttle, pwm, collective_thrust };
enum class Hold { unknown, zoh, linear };
// What rotors do between the rows of a log: as `hold` has it; where it does not say how commands go on, from the command of a row to the speed that the
// next one measures, or what a faster loop adds, which is not logged; where commands are held, from one measured speed to the next
// as the rotors of the vehicle file answer.
enum class BetweenRows { as_said, from_command_to_speed, loop_goes_on, as_answered };
std::string_view to_string(ActuatorKind kind);
std::string_view to_string(Hold hold);

struct LogColumn {
  std::string name;
  std::vector<double> values;  // one per row; NaN: no sample
};

// u1…uN and rotor1…rotorN: what drives the rotors, and how fast they turned.
bool is_rotor_column(std::string_view name);

struct LogMeta {
  std::string vehicle;  // as written: a name under models/ or a path
  ActuatorKind actuator = ActuatorKind::rotor_speed;
  std::string source = "recording";  // simulation | recording
  Hold hold = Hold::unknown;
  BetweenRows between_rows = BetweenRows::as_said;  // no key of a file: found by the diagnosis
  std::string notes;
  Environment environment;
  // free keys, values as TOML literals; condition is shown and never fitted
  std::vector<std::pair<std::string, std::string>> condition;
  std::vector<std::pair<std::string, std::string>> origin;  // original file, sha256, importer, known issues
};

// What was found and repaired while reading, in words; file:line:col first.
struct LogRepair {
  std::string kind;  // duplicate | quaternion_norm | unknown_column
  std::string says;
};

struct FlightLog {
  std::string path;                // as given
  std::vector<double> time_s;      // strictly increasing
  std::vector<LogColumn> columns;  // every column but time_s, in file order
  LogMeta meta;
  std::vector<LogRepair> repairs;

  std::size_t rows() const { return time_s.size(); }
  // nullptr when absent
  const std::vector<double>* find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) != nullptr; }
  // Number of columns prefix1, prefix2, … (u1…uN, rotor1…rotorN).
  int count(std::string_view prefix) const;
};

// Of a gap in time only so much is walked through step by step, and counts as flight: rotors have settled by then, and work goes with
// rows, whatever their times are.
inline constexpr double longest_walk_s = 10.0;

// From one time, included, to another, not included.
struct TimeRange {
  double from_s, to_s;
};

// Reads NAME.csv or NAME.csv.gz and NAME.meta.toml. Throws DataError with file:line:col. Repairs only what needs no guess.
// `only`: without the rows whose time lies in none of these; empty: all rows.
FlightLog read_flight_log(const std::string& csv_path, const std::vector<TimeRange>& only = {});
// The same in parts of at most so many rows, one after the other, so that memory is that of one: `part` may use it until it returns. What
// is wrong with the log as a whole (no motion, an attitude that contradicts the body rate) is thrown before the last. Repairs: so far.
void read_flight_log_in_parts(const std::string& csv_path, const std::function<void(const FlightLog& part)>& part,
                              std::size_t most_rows = 50'000);
// NAME.meta.toml of NAME.csv or NAME.csv.gz. Throws DataError for any other name.
std::string sidecar_path(const std::string& csv_path);
// Writes both files, each whole or not at all; throws IoError. Numbers are the shortest text that reads back the same.
void write_flight_log(const FlightLog& log, const std::string& csv_path);

}  // namespace gustlab
