// Tables of a sweep: mean ± sample standard deviation over runs, median, and how many runs were completed.
#pragma once

#include <array>
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
  std::string_view name;    // of the column in runs.csv
  std::string_view title;
  double ResultRow::*value;
};
inline constexpr std::array<Metric, 5> tracking_metrics{{
    {"rmse_xy_m", "RMSE", &ResultRow::rmse_xy_m},
    {"mae_xy_m", "MAE", &ResultRow::mae_xy_m},
    {"p95_xy_m", "P95", &ResultRow::p95_xy_m},
    {"max_xy_m", "Max", &ResultRow::max_xy_m},
    {"rmse_z_m", "RMSE z", &ResultRow::rmse_z_m},
}};

// All runs of one vehicle, trajectory and controller.
struct TableCell {
  std::string experiment, vehicle, trajectory, controller;
  std::size_t completed = 0, total = 0;
  std::array<Summary, tracking_metrics.size()> errors;  // over all runs, crashed ones too
};
// In the order in which the cells first appear.
std::vector<TableCell> aggregate(const std::vector<ResultRow>& rows);

std::string to_table(const Results& results, TableFormat format);

}  // namespace gustlab
