// Results as rows: what runs.csv says and what tables and gates read.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "simulation/flight.hpp"

namespace gustlab {

// One row of runs.csv. Errors are NaN when no sample counted.
struct ResultRow {
  std::string experiment, vehicle, trajectory, controller;
  std::int64_t replicate = 0;
  Outcome outcome = Outcome::completed;
  double duration_s = 0.0;
  double rmse_xy_m = std::numeric_limits<double>::quiet_NaN();
  double mae_xy_m = rmse_xy_m, p95_xy_m = rmse_xy_m, max_xy_m = rmse_xy_m, rmse_z_m = rmse_xy_m;
  std::string key{};
  // what it asked of the rotors; NaN when too few samples counted
  double rotor_sd_radps = std::numeric_limits<double>::quiet_NaN(), rotor_rate_radps2 = rotor_sd_radps;
  std::vector<NamedValue> axes{};  // of its variant; the same axes in every row
};

// Every planned run in plan order, and what a table has to say beside them.
struct Results {
  std::vector<ResultRow> rows;
  double settle_s = 0.0;
  std::vector<NamedValue> axis_units{};  // unit of an axis, "-" without a dimension; none where it is not known
  std::vector<NamedValue> arcs{};        // how much of each trajectory was flown; empty where variants differ
};

// Whether a flight can have such an error or duration: NaN (no sample counted), or from 0 to 1e12 m or s. MuJoCo calls a
// flight diverged long before that, and squares of larger numbers overflow.
bool is_figure(double value);

// The first line of runs.csv, with a column of its own for each axis, one of its rows, and the whole.
std::string csv_header(const std::vector<NamedValue>& axes);
std::string csv_line(const ResultRow& row);
std::string to_csv(const std::vector<ResultRow>& rows);
// Throws ConfigError when an axis is called like a column of runs.csv.
void check_axis_names(const Experiment& experiment);
// Throws DataError with file:line:col.
std::vector<ResultRow> read_results_csv(const std::string& path);

}  // namespace gustlab
