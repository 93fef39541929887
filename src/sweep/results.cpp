#include "sweep/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

constexpr std::string_view header =
    "experiment,vehicle,trajectory,controller,replicate,outcome,duration_s,rmse_xy_m,mae_xy_m,p95_xy_m,max_xy_m,rmse_z_"
    "m,key";
// behind them, where the table is of this version of the program; behind these, the axes
constexpr std::string_view effort_columns = ",rotor_sd_radps,rotor_rate_radps2";

std::string cell(double value) { return std::isnan(value) ? "" : config::shortest(value); }

// the next line, without the \r that other systems and git put before its end
bool next_line(std::istream& file, std::string& line) {
  if (!std::getline(file, line)) return false;
  if (line.ends_with('\r')) line.pop_back();
  return true;
}

// a line's cells, one taken after the other
class Cells {
 public:
  Cells(std::string_view line, std::string where) : line_(line), where_(std::move(where)) {}

  std::string_view next() {
    start_ = done_ ? line_.size() : end_;
    if (done_) fail("a cell is missing", std::string(header));
    const std::size_t comma = line_.find(',', start_);
    const std::string_view text = line_.substr(start_, comma == std::string_view::npos ? comma : comma - start_);
    done_ = comma == std::string_view::npos;
    end_ = comma + 1;
    return text;
  }
  // an empty cell leaves the value as it is
  template <class Number>
  std::string_view next(Number& value) {
    const std::string_view text = next();
    if (text.empty()) return text;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || rest != text.data() + text.size())
      fail(fmt::format("\"{}\" is not a number", text), "");
    return text;
  }
  void next_figure(double& value, bool needed = false) {
    const bool empty = next(value).empty();
    if (needed && empty) fail("the cell is empty, and the run was completed", "a number from 0 to 1e12");
    if (!is_figure(value) || (!empty && std::isnan(value)))
      fail(fmt::format("{} is no figure of a flight", value), "a number from 0 to 1e12, or an empty cell");
  }
  void finish() {
    if (!done_) fail("there are too many cells", std::string(header));
  }
  [[noreturn]] void fail(const std::string& problem, const std::string& why) const {
    throw DataError(
        fmt::format("{}:{}: {}{}", where_, start_ + 1, problem, why.empty() ? "" : fmt::format(" (expected {})", why)));
  }

 private:
  std::string_view line_;
  std::string where_;
  std::size_t start_ = 0, end_ = 0;
  bool done_ = false;
};

}  // namespace

bool is_figure(double value) { return std::isnan(value) || (value >= 0.0 && value <= 1e12); }

std::string csv_header(const std::vector<NamedValue>& axes) {
  std::string text = fmt::format("{}{}", header, effort_columns);
  for (const NamedValue& axis : axes) text += "," + axis.name;
  return text + "\n";
}

std::string csv_line(const ResultRow& row) {
  std::string text =
      fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", row.experiment, row.vehicle, row.trajectory,
                  row.controller, row.replicate, to_string(row.outcome), cell(row.duration_s), cell(row.rmse_xy_m),
                  cell(row.mae_xy_m), cell(row.p95_xy_m), cell(row.max_xy_m), cell(row.rmse_z_m), row.key,
                  cell(row.rotor_sd_radps), cell(row.rotor_rate_radps2));
  for (const NamedValue& axis : row.axes) text += "," + axis.value;
  return text + "\n";
}

std::string to_csv(const std::vector<ResultRow>& rows) {
  std::string text = csv_header(rows.empty() ? std::vector<NamedValue>{} : rows.front().axes);
  for (const ResultRow& row : rows) text += csv_line(row);
  return text;
}

void check_axis_names(const Experiment& experiment) {
  for (const NamedValue& axis : experiment.axes)
    if (fmt::format(",{}{},", header, effort_columns).find(fmt::format(",{},", axis.name)) != std::string::npos)
      throw ConfigError(fmt::format("{}: an axis is called \"{}\" (runs.csv has such a column); give it another name",
                                    experiment.name, axis.name));
}

std::vector<ResultRow> read_results_csv(const std::string& path) {
  std::istringstream file(read_file<DataError>(path));
  std::string line;
  if (!next_line(file, line) || (line != header && !line.starts_with(std::string(header) + ",")))
    throw DataError(fmt::format("{}:1:1: not a table of runs (expected the header {})", path, header));
  line.erase(0, header.size());
  const bool has_effort = line.starts_with(effort_columns);
  if (has_effort) line.erase(0, effort_columns.size());
  std::vector<NamedValue> axes;
  for (std::istringstream names(line.empty() ? line : line.substr(1)); std::getline(names, line, ',');)
    axes.push_back({line, ""});

  std::vector<ResultRow> rows;
  std::map<std::string, int> lines;  // of each run
  for (int number = 2; next_line(file, line); ++number) {
    Cells cells(line, fmt::format("{}:{}", path, number));
    ResultRow row;
    for (std::string* text : {&row.experiment, &row.vehicle, &row.trajectory, &row.controller}) *text = cells.next();
    cells.next(row.replicate);
    const std::string_view outcome = cells.next();
    if (const auto known = find_outcome(outcome)) row.outcome = *known;
    else cells.fail(fmt::format("\"{}\" is no outcome", outcome), "completed, crashed, …");
    for (double* value : {&row.duration_s, &row.rmse_xy_m, &row.mae_xy_m, &row.p95_xy_m, &row.max_xy_m, &row.rmse_z_m})
      cells.next_figure(*value, row.outcome == Outcome::completed);
    row.key = cells.next();
    if (has_effort)
      for (double* value : {&row.rotor_sd_radps, &row.rotor_rate_radps2}) cells.next_figure(*value);
    row.axes = axes;
    for (NamedValue& axis : row.axes) axis.value = cells.next();
    cells.finish();
    const std::string run =
        fmt::format("{},{},{},{},{}", row.experiment, row.vehicle, row.trajectory, row.controller, row.replicate);
    if (const auto [first, is_new] = lines.emplace(run, number); !is_new)
      throw DataError(
          fmt::format("{}:{}:1: run {} stands in line {} already; leave one out", path, number, run, first->second));
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace gustlab
