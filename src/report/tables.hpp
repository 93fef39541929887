// Tables of a sweep: mean ± sample standard deviation over runs, median, and how many runs were completed.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "metrics/statistics.hpp"
#include "sweep/results.hpp"

namespace gustlab {

enum class TableFormat { md, csv, latex, json };
std::optional<TableFormat> find_table_format(std::string_view name);

// The tracking errors of a run that tables show and gates compare.
struct Metric {
  std::string_view name;  // of the column in runs.csv
  std::string_view title;
  std::string_view latex;
  double ResultRow::*value;
};
inline constexpr std::array<Metric, 5> tracking_metrics{{
    {"rmse_xy_m", "RMSE", "RMSE$_{xy}$", &ResultRow::rmse_xy_m},
    {"mae_xy_m", "MAE", "MAE$_{xy}$", &ResultRow::mae_xy_m},
    {"p95_xy_m", "P95", "P95$_{\\|xy\\|}$", &ResultRow::p95_xy_m},
    {"max_xy_m", "Max", "Max$_{\\|xy\\|}$", &ResultRow::max_xy_m},
    {"rmse_z_m", "RMSE z", "RMSE$_{z}$", &ResultRow::rmse_z_m},
}};
// A metric's place by its name, or the beginning of it: rmse, p95, rmse_z.
std::optional<std::size_t> find_tracking_metric(std::string_view name);

// All runs of one vehicle, trajectory and controller.
struct TableCell {
  std::string experiment, vehicle, trajectory, controller;
  std::vector<NamedValue> axes;
  std::size_t completed = 0, total = 0;
  // over all runs, crashed ones too, but for those that ended before a sample counted
  std::array<Summary, tracking_metrics.size()> errors;
};
// "grid" of a variant grid.calm, of which there may be many, and of an experiment without variants.
std::string without_variant(const std::string& experiment);
// In the order in which the cells first appear.
std::vector<TableCell> aggregate(const std::vector<ResultRow>& rows);
// "5", or "3 to 5" where cells differ: runs of each cell.
std::string runs_of_each(const std::vector<TableCell>& cells);
// " Flown: lemniscate 15 s, 2.8 m, 0.62 laps." with the names of the table; empty where the sweep does not say.
std::string flown_in_words(const Results& results, const std::map<std::string, std::string>& names = {});
// "2/3", and how many runs have an error where some have none: "1/3, n = 2".
std::string completed_of(const TableCell& cell);
// Completed the larger share of its runs; or as large a share, and more of them have an error; or both alike, with the lesser mean of
// a metric. Errors up to a crash are no better than those of a whole flight, and no crash is better for its errors not being counted.
bool is_better(const TableCell& cell, const TableCell& other, std::size_t metric);

struct TableOptions {
  TableFormat format = TableFormat::md;
  std::vector<std::size_t> columns{0, 1, 2, 3, 4};  // of tracking_metrics
  // the best of each trajectory (and point of the axes), by is_better
  bool bold_best = false;
  std::map<std::string, std::string> names{};  // what a vehicle, trajectory, controller or axis is called in the table
  std::string label{};                         // LaTeX's; empty: the experiment's name
};
std::string to_table(const Results& results, const TableOptions& options);

}  // namespace gustlab
