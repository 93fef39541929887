// Fits what the paper leaves open to some of the cells of a table (NAME.calibration.toml beside an experiment).
//
// Stage after stage, each with its own targets and parameters: the loss is the mean of ln(ours/paper)² over the targets,
// which are means and, where asked for, standard deviations over runs, on seeds that are not the reported ones. Search:
// Bobyqa (Powell 2009) of NLopt, Subplex (Rowan 1990) for a single parameter, in coordinates from 0 to 1, from the start that
// the file gives. The same input gives the same values.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/published.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

// A key of the experiment that may vary.
struct OpenParameter {
  std::string key;  // dotted, as in --set
  double min, max, start;
  bool log = false;  // searched by its logarithm
  std::string unit;
  std::string where = {};  // file:line:col
};

// What a stage looks at: over the runs of a cell of the paper's table, the mean or the standard deviation, which tells how
// heavy the tails are.
enum class Statistic { mean, sd };
inline constexpr std::array<std::string_view, 2> statistic_names{"mean", "sd"};
inline double statistic_of(const Summary& summary, Statistic statistic) {
  return statistic == Statistic::mean ? summary.mean : summary.sd;
}
struct Target {
  std::string trajectory, controller;
  std::size_t metric;  // of published_metrics
  Statistic statistic = Statistic::mean;
  std::string where = {};  // file:line:col
};

struct CalibrationStage {
  std::string name;
  std::int64_t evaluations = 100;
  std::vector<Target> targets;
  std::vector<OpenParameter> parameters;
};

// A cell that no stage looks at and that is no blind prediction all the same.
struct KnownCell {
  std::string trajectory, controller;
  std::size_t metric;
  bool by_construction;  // else: a choice was made after it had been seen
};

struct Calibration {
  std::string table;
  std::int64_t first_replicate = 1001, replicates = 10;
  std::vector<CalibrationStage> stages;
  std::vector<KnownCell> known{};                  // [[known]]
  std::string first_where = {}, count_where = {};  // file:line:col of the replicates

  // whether a stage looks at the cell
  bool fits(std::string_view trajectory, std::string_view controller, std::size_t metric) const;
  const KnownCell* find_known(std::string_view trajectory, std::string_view controller, std::size_t metric) const;
};

// `experiment.toml` → `experiment.calibration.toml`, whether it is there or not.
std::string calibration_path(const std::string& experiment_path);
// Throws ConfigError with file:line:col.
Calibration read_calibration(const std::string& path);

struct StageResult {
  std::vector<double> values;  // of the stage's parameters
  double start_loss = 0.0, loss = 0.0;
  std::vector<double> figures;  // ours, of the stage's targets, m
  // of 1000 tables with the paper's number of runs, drawn from ours with replacement: the share at least as far (in the same
  // mean of squared logarithms) from all of ours as the paper's is. Parameters were fitted first, so it flatters.
  double share_as_far = 0.0;
  std::int64_t evaluations = 0, flights = 0;
};

// Flies the stages; `overrides` are --set pairs that hold throughout. `progress` gets evaluations done and planned. Stops
// early, with fewer results than stages, when `stop` becomes true. Throws ConfigError, before anything flies, when the
// experiment reports a seed that is calibrated on, has no such key, or the paper no such cell. What was flown is kept in `flown_file`
// (evaluations.hpp), unless that is empty, and is not flown again.
std::vector<StageResult> calibrate(const std::string& experiment_path, const std::vector<std::string>& overrides,
                                   const Calibration& calibration, const Published& published, int jobs,
                                   const std::atomic<bool>& stop,
                                   const std::function<void(std::size_t done, std::size_t all)>& progress,
                                   const std::string& flown_file = {});

}  // namespace gustlab
