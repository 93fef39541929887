#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "flight_log/checks.hpp"
#include "flight_log/columns.hpp"
#include "flight_log/csv.hpp"
#include "flight_log/sidecar.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

constexpr double worst_norm_error = 0.02;
constexpr double norm_rounding = 1e-5;  // what six printed digits leave

// index of a column, or −1
int find(const CsvNumbers& csv, std::string_view name) {
  const auto found = std::find(csv.names().begin(), csv.names().end(), name);
  return found == csv.names().end() ? -1 : static_cast<int>(found - csv.names().begin());
}

// indices of several columns; empty when one is missing
std::vector<std::size_t> find_all(const CsvNumbers& csv, std::initializer_list<const char*> names) {
  std::vector<std::size_t> result;
  for (const char* name : names) {
    const int index = find(csv, name);
    if (index < 0) return {};
    result.push_back(static_cast<std::size_t>(index));
  }
  return result;
}

[[noreturn]] void missing(const CsvNumbers& csv, const std::string& path, const std::string& what,
                          const std::string& why, std::string_view column = {}) {
  const std::string near = column.empty() ? "" : suggest_column(column, csv.names());
  throw DataError(worded(fmt::format("{}:1:1: {}", path, what), why, near));
}

void check_names(const CsvNumbers& csv, const std::string& path) {
  if (find(csv, "time_s") < 0) missing(csv, path, "column \"time_s\" is missing", "every sample has a time", "time_s");
  if (find(csv, "u1") < 0 && find(csv, "rotor1") < 0)
    missing(csv, path, "there is no actuator input", "u1 and so on, or rotor1 and so on, are needed", "rotor1");
  for (const char* prefix : {"u", "rotor"})
    for (int i = 2; i <= max_rotors; ++i)
      if (const int c = find(csv, fmt::format("{}{}", prefix, i));
          c >= 0 && find(csv, fmt::format("{}{}", prefix, i - 1)) < 0)
        throw DataError(fmt::format("{}: column \"{}{}\" is here and \"{}{}\" is not (one column per rotor)",
                                    csv.where_name(static_cast<std::size_t>(c)), prefix, i, prefix, i - 1));
}

// what no sensor says overflows in a statistic: one such cell is an error of the log
void check_sizes(const CsvNumbers& csv) {
  for (std::size_t c = 0; c < csv.names().size(); ++c) {
    const std::vector<double>& values = csv.column(c);
    const auto most = most_of_column(csv.names()[c]);
    if (!most) continue;
    const auto wrong =
        std::find_if(values.begin(), values.end(), [&](double value) { return std::abs(value) > *most; });
    if (wrong == values.end()) continue;
    throw DataError(fmt::format(
        "{}: {:.4g} in column {} is no measurement (at most {:g}); leave the cell empty when there is no sample",
        csv.where(static_cast<std::size_t>(wrong - values.begin()), c), *wrong, csv.names()[c], *most));
  }
}

// What is asked of a log's rows, which may come in parts: each looks at the next ones, and repairs them.
class RowChecks {
 public:
  explicit RowChecks(std::string path) : path_(std::move(path)) {}

  // Throws DataError; with the last part also for what is wrong with all of them together.
  void check(CsvNumbers& csv) {
    see_samples(csv);
    check_sizes(csv);
    check_time(csv);
    check_attitude(csv);
  }
  // of all parts so far
  std::vector<LogRepair> repairs() const {
    std::vector<LogRepair> result;
    if (duplicates_ > 0)
      result.push_back({"duplicate", fmt::format("{}: {} rows repeat the one before and are dropped", first_duplicate_,
                                                 duplicates_)});
    if (normalised_ > 0)
      result.push_back(
          {"quaternion_norm", fmt::format("{}: {} quaternions are off norm by up to {:.2g} and are normalised",
                                          first_normalised_, normalised_, worst_norm_)});
    return result;
  }

 private:
  void see_samples(const CsvNumbers& csv) {
    if (sampled_.empty()) sampled_.resize(csv.names().size(), false);
    rows_ += csv.rows();
    for (std::size_t c = 0; c < sampled_.size(); ++c) {
      const std::vector<double>& values = csv.column(c);
      sampled_[c] = sampled_[c] || std::any_of(values.begin(), values.end(), [](double v) { return !std::isnan(v); });
    }
    if (!csv.at_end()) return;
    if (rows_ == 0) throw DataError(fmt::format("{}: the log is empty (0 samples)", path_));
    if (rows_ == 1) throw DataError(fmt::format("{}: the log has one sample (two or more are needed)", path_));
    const auto has_samples = [&](std::initializer_list<const char*> names) {
      const std::vector<std::size_t> group = find_all(csv, names);
      return !group.empty() && std::all_of(group.begin(), group.end(), [&](std::size_t c) { return sampled_[c]; });
    };
    if (!has_samples({"px", "py", "pz"}) && !has_samples({"ax", "ay", "az"}) && !has_samples({"wx", "wy", "wz"}))
      missing(csv, path_, "nothing tells the motion", "px, py, pz or ax, ay, az or wx, wy, wz are needed");
  }

  // time must rise; a row that repeats the one before is dropped
  void check_time(CsvNumbers& csv) {
    const auto c = static_cast<std::size_t>(find(csv, "time_s"));
    const std::vector<double>& time_s = csv.column(c);
    std::vector<bool> wanted(csv.rows(), true);
    const std::size_t before = duplicates_;
    for (std::size_t row = 0; row < csv.rows(); ++row) {
      if (std::isnan(time_s[row])) throw DataError(fmt::format("{}: this sample has no time", csv.where(row, c)));
      const bool has_last = row > 0 || !last_row_.empty();
      const double last_s = row > 0 ? time_s[row - 1] : has_last ? last_row_[c] : 0.0;
      if (!has_last || time_s[row] > last_s) continue;
      if (row > 0 ? !csv.same(row, row - 1) : !csv.same(row, last_row_))
        throw DataError(
            fmt::format("{}: time does not rise ({} s after {} s)", csv.where(row, c), time_s[row], last_s));
      wanted[row] = false;
      if (duplicates_++ == 0) first_duplicate_ = csv.where_row(row);
    }
    if (csv.rows() > 0) last_row_ = csv.cells(csv.rows() - 1);
    if (duplicates_ > before) csv.keep(wanted);
  }

  void check_attitude(CsvNumbers& csv) {
    const std::vector<std::size_t> q = find_all(csv, {"qw", "qx", "qy", "qz"});
    if (q.empty()) return;
    for (std::size_t row = 0; row < csv.rows(); ++row) {
      double square = 0.0;
      for (const std::size_t c : q) square += csv.column(c)[row] * csv.column(c)[row];
      if (std::isnan(square)) continue;
      const double norm = std::sqrt(square), error = std::abs(norm - 1.0);
      if (error > worst_norm_error)
        throw DataError(
            fmt::format("{}: the quaternion's norm is {:.4g} (1 is needed, {} is the most that is repaired)",
                        csv.where(row, q[0]), norm, worst_norm_error));
      if (error <= norm_rounding) continue;
      for (const std::size_t c : q) csv.column(c)[row] /= norm;
      worst_norm_ = std::max(worst_norm_, error);
      if (normalised_++ == 0) first_normalised_ = csv.where(row, q[0]);
    }
    const std::vector<std::size_t> w = find_all(csv, {"wx", "wy", "wz"});
    if (w.empty()) return;
    const AttitudeColumns columns{csv.column(static_cast<std::size_t>(find(csv, "time_s"))),
                                  {&csv.column(q[0]), &csv.column(q[1]), &csv.column(q[2]), &csv.column(q[3])},
                                  {&csv.column(w[0]), &csv.column(w[1]), &csv.column(w[2])}};
    if (const auto row = attitude_.add(columns)) contradiction_ = csv.line(*row);
    if (csv.at_end() && attitude_.contradicts())
      throw DataError(worded(csv.where(contradiction_, q[0]) + ": the attitude contradicts the body rate",
                             "from here on they turn differently", attitude_.suggestion()));
  }

  std::string path_;
  std::size_t rows_ = 0, duplicates_ = 0, normalised_ = 0;
  std::vector<bool> sampled_;     // of each column, whether it has a sample
  std::vector<double> last_row_;  // of the part before
  std::string first_duplicate_, first_normalised_;
  double worst_norm_ = 0.0;
  AttitudeCheck attitude_;
  CsvNumbers::Line contradiction_{1, 0};
};

void read_parts(const std::string& csv_path, const std::vector<TimeRange>& only, std::size_t most_rows,
                const std::function<void(FlightLog& part)>& part) {
  FlightLog log;
  log.path = csv_path;
  const std::string sidecar = sidecar_path(csv_path);
  if (const std::string why = why_unreadable(csv_path); !why.empty())
    throw DataError(fmt::format("{}: cannot read ({})", csv_path, why));
  if (const std::string why = why_unreadable(sidecar); !why.empty())
    throw DataError(
        fmt::format("{}: cannot read ({}); a log needs its sidecar; gustlab import writes both, gustlab "
                    "defaults sidecar prints one",
                    sidecar, why));
  log.meta = read_sidecar(sidecar);
  note_input(csv_path);
  CsvNumbers csv(
      csv_path, [](std::string_view name) { return !is_known_column(name); }, only, most_rows);
  check_names(csv, csv_path);
  std::vector<std::string> unknown;
  for (const std::string& name : csv.names())
    if (!is_known_column(name)) unknown.push_back(name);
  RowChecks checks(csv_path);
  while (true) {
    checks.check(csv);
    log.repairs = checks.repairs();
    // a simulated log holds the telemetry of its controller, too
    if (!unknown.empty() && log.meta.source == "recording")
      log.repairs.push_back(
          {"unknown_column", fmt::format("{}:1: unknown columns are ignored: {}", csv_path, fmt::join(unknown, ", "))});
    log.columns.clear();
    for (std::size_t c = 0; c < csv.names().size(); ++c) {
      const std::string& name = csv.names()[c];
      if (name == "time_s") log.time_s = std::move(csv.column(c));
      else log.columns.push_back({name, std::move(csv.column(c))});
    }
    part(log);
    if (csv.at_end()) return;
    csv.read_on();
  }
}

}  // namespace

FlightLog read_flight_log(const std::string& csv_path, const std::vector<TimeRange>& only) {
  FlightLog all;
  read_parts(csv_path, only, CsvNumbers::all_rows, [&](FlightLog& log) { all = std::move(log); });
  return all;
}

void read_flight_log_in_parts(const std::string& csv_path, const std::function<void(const FlightLog& part)>& part,
                              std::size_t most_rows) {
  read_parts(csv_path, {}, most_rows, [&](FlightLog& log) { part(log); });
}

}  // namespace gustlab
