// What the paper published: the means of its tables, and what it claims (experiments/published_tables.toml).
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "metrics/statistics.hpp"
#include "metrics/tracking_error.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

// The figures of a table's row, planar, by their names in runs.csv.
inline constexpr std::array<std::string_view, 4> published_metrics{"rmse_xy_m", "mae_xy_m", "p95_xy_m", "max_xy_m"};
inline std::array<double, 4> published_figures(const ErrorFigures& planar) {
  return {planar.rmse_m, planar.mae_m, planar.p95_m, planar.max_m};
}

struct PublishedRow {
  std::string table, trajectory, controller;
  std::array<Summary, published_metrics.size()> figures;  // n, mean, sd; no median
};

enum class ClaimKind {
  less,        // `first` has the lower mean error than `second`
  reduced,     // lower by the share `by`, at least
  steadier,    // its runs scatter less
  runaway,     // one run of `first` lies far outside the others
  completion,  // all runs of `first` reach their end, or none
  below,       // every error of a table is below the same of another
};

// One side of a comparison; empty: not needed.
struct ClaimSide {
  std::string table, trajectory, controller;
};
struct Claim {
  ClaimKind kind;
  ClaimSide first, second;
  std::size_t metric = 0;  // of published_metrics
  double by = 0.0;
  bool all = true;
  // of `below`: what is left out
  std::string except_trajectory;
  std::optional<std::size_t> except_metric;
};

struct Published {
  std::vector<PublishedRow> rows;
  std::vector<Claim> claims;
  std::map<std::string, std::string> vehicles;  // of each table

  // Throws ConfigError when the experiment flies another vehicle than the table is of.
  void check_vehicle(const std::string& table, const Experiment& experiment) const;
  const PublishedRow* find(std::string_view table, std::string_view trajectory, std::string_view controller) const;
};

// Throws ConfigError with file:line:col.
Published read_published(const std::string& path);

// A metric's place in published_metrics. Throws ConfigError at the place.
std::size_t find_published_metric(const std::string& name, const std::string& where);

}  // namespace gustlab
