#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlopt.hpp>

#include "calibration/calibration.hpp"
#include "calibration/evaluations.hpp"
#include "config/toml.hpp"
#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/random.hpp"
#include "sweep/fresh_replicates.hpp"
#include "sweep/sweep.hpp"
#include "util/sha256.hpp"

namespace gustlab {

namespace {

// what a flight that does not reach its end adds to the loss: no run of the paper's simulations crashed
constexpr double crash_loss = 4.0;

double to_unit(const OpenParameter& p, double value) {
  return p.log ? std::log(value / p.min) / std::log(p.max / p.min) : (value - p.min) / (p.max - p.min);
}

// three digits: what a reader can copy, and all that the seeds can tell
double from_unit(const OpenParameter& p, double unit) {
  const double value = p.log ? p.min * std::pow(p.max / p.min, unit) : p.min + unit * (p.max - p.min);
  return std::clamp(std::stod(fmt::format("{:.3g}", value)), p.min, p.max);
}

std::string quoted_list(const std::vector<std::string>& names) {
  return fmt::format("[\"{}\"]", fmt::join(names, "\", \""));
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// mean of squared logarithms of ratios
double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::log(a[i] / b[i]) * std::log(a[i] / b[i]);
  return sum / static_cast<double>(a.size());
}

// evaluates one stage at points of the unit cube
class Objective {
 public:
  Objective(const std::string& path, const std::vector<std::string>& overrides, const Calibration& calibration,
            const CalibrationStage& stage, const Published& published, int jobs, Evaluations& flown)
      : path_(path), overrides_(overrides), stage_(stage), jobs_(jobs), flown_(flown) {
    std::vector<std::string> trajectories, controllers;
    for (const Target& cell : stage.targets) {
      add_once(trajectories, cell.trajectory);
      add_once(controllers, cell.controller);
      const PublishedRow* row = published.find(calibration.table, cell.trajectory, cell.controller);
      if (row == nullptr)
        throw ConfigError(fmt::format("{}: {} has no row {} {} (a target is a cell that was published)", cell.where,
                                      calibration.table, cell.trajectory, cell.controller));
      published_.push_back(statistic_of(row->figures[cell.metric], cell.statistic));
      if (!(published_.back() > 0.0))
        throw ConfigError(
            fmt::format("{}: the {} of {} {} is published as zero (the loss is a logarithm); leave it out", cell.where,
                        statistic_names[static_cast<std::size_t>(cell.statistic)], cell.trajectory, cell.controller));
      published_runs_ = row->figures[cell.metric].n;
    }
    overrides_.push_back("trajectories=" + quoted_list(trajectories));
    overrides_.push_back("controllers=" + quoted_list(controllers));
    overrides_.push_back(fmt::format("first_replicate={}", calibration.first_replicate));
    overrides_.push_back(fmt::format("replicates={}", calibration.replicates));
  }

  std::vector<double> values(const std::vector<double>& unit) const {
    std::vector<double> result;
    for (std::size_t i = 0; i < unit.size(); ++i) result.push_back(from_unit(stage_.parameters[i], unit[i]));
    return result;
  }
  std::vector<std::string> overrides_of(const std::vector<double>& values) const {
    std::vector<std::string> result;
    for (std::size_t i = 0; i < values.size(); ++i)
      result.push_back(fmt::format("{}={}", stage_.parameters[i].key, config::shortest(values[i])));
    return result;
  }

  double operator()(const std::vector<double>& unit) {
    const std::vector<double> at = values(unit);
    if (const auto known = known_.find(at); known != known_.end()) return known->second;
    const Evaluation found = evaluate(at);
    known_.emplace(at, found.loss);
    if (best.values.empty() || found.loss < best.loss) {
      best.values = at;
      best.loss = found.loss;
      best.figures = found.figures;
      best_runs_ = found.runs;
    }
    return found.loss;
  }

  // the best one's StageResult::share_as_far
  double share_as_far() const {
    constexpr std::uint32_t tables = 1000;
    const RandomStream stream(1, 0, "calibration");
    const double paper = distance(published_, best.figures);
    std::uint32_t far = 0;
    std::vector<double> drawn(published_runs_), figures(best_runs_.size());
    for (std::uint32_t table = 0; table < tables; ++table) {
      // one draw of gusts for all cells
      for (std::size_t i = 0; i < best_runs_.size(); ++i) {
        for (std::size_t run = 0; run < drawn.size(); ++run)
          drawn[run] = best_runs_[i][static_cast<std::size_t>(stream.uniform4(run, table)[0] *
                                                              static_cast<double>(best_runs_[i].size()))];
        figures[i] = statistic_of(summarize(drawn), stage_.targets[i].statistic);
      }
      if (!(distance(figures, best.figures) < paper)) ++far;
    }
    return static_cast<double>(far) / tables;
  }

  StageResult best;

 private:
  // flies, or takes what was flown before
  Evaluation evaluate(const std::vector<double>& at) {
    std::vector<std::string> overrides = overrides_;
    for (std::string& text : overrides_of(at)) overrides.push_back(std::move(text));
    const Experiment experiment = read_experiment(path_, overrides);
    const std::vector<RunSpec> runs = plan(experiment);
    best.flights += static_cast<std::int64_t>(runs.size());
    std::string key(build_info().commit);
    for (const RunSpec& run : runs) key += to_hex(run.key);
    for (std::size_t i = 0; i < published_.size(); ++i) {
      const Target& cell = stage_.targets[i];
      key += fmt::format("\n{} {} {} {} {}", cell.trajectory, cell.controller, cell.metric,
                         static_cast<int>(cell.statistic), published_[i]);
    }
    key = sha256(key);
    if (const Evaluation* known = flown_.find(key)) return *known;
    Evaluation found = fly(experiment, runs);
    flown_.add(key, found);
    return found;
  }

  Evaluation fly(const Experiment& experiment, const std::vector<RunSpec>& runs) const {
    const std::vector<RunRecord> records = fly_all(experiment, runs, jobs_);
    const auto crashed = std::count_if(records.begin(), records.end(),
                                       [](const RunRecord& r) { return r.outcome != Outcome::completed; });
    Evaluation found;
    found.loss = crash_loss * static_cast<double>(crashed) / static_cast<double>(records.size());
    for (const Target& cell : stage_.targets) {
      std::vector<double> ours;
      for (const RunRecord& record : records)
        if (experiment.trajectories[record.spec.trajectory].name == cell.trajectory &&
            experiment.controllers[record.spec.controller].name == cell.controller)
          ours.push_back(published_figures(record.error.planar)[cell.metric]);
      found.figures.push_back(statistic_of(summarize(ours), cell.statistic));
      found.runs.push_back(std::move(ours));
    }
    found.loss += distance(found.figures, published_);
    if (!std::isfinite(found.loss)) found.loss = 1e3;
    return found;
  }

  std::string path_;
  std::vector<std::string> overrides_;
  const CalibrationStage& stage_;
  int jobs_;
  Evaluations& flown_;
  std::vector<double> published_;               // of each target
  std::vector<std::vector<double>> best_runs_;  // of each target, by replicate
  std::size_t published_runs_ = 0;              // in a row of the table
  std::map<std::vector<double>, double> known_;
};

// Minimises the loss of a stage from a start in units of the parameters' ranges; the objective keeps its best.
void search_stage(Objective& objective, std::vector<double> at, std::int64_t evaluations, const std::atomic<bool>& stop,
                  const std::function<void()>& evaluated) {
  // Bobyqa wants two dimensions
  nlopt::opt search(at.size() > 1 ? nlopt::LN_BOBYQA : nlopt::LN_SBPLX, static_cast<unsigned>(at.size()));
  auto evaluate = [&](const std::vector<double>& x) {
    if (stop) search.force_stop();
    evaluated();
    return objective(x);
  };
  using Evaluate = decltype(evaluate);
  search.set_min_objective(
      [](const std::vector<double>& x, std::vector<double>&, void* data) { return (*static_cast<Evaluate*>(data))(x); },
      &evaluate);
  search.set_lower_bounds(0.0);
  search.set_upper_bounds(1.0);
  search.set_initial_step(0.15);
  search.set_xtol_abs(1e-3);
  search.set_maxeval(static_cast<int>(std::max<std::int64_t>(evaluations - 1, 1)));
  try {
    double loss = 0.0;
    search.optimize(at, loss);
  } catch (const nlopt::forced_stop&) {
  } catch (const nlopt::roundoff_limited&) {
    // the loss has steps as fine as three digits: as good as it gets
  } catch (const std::runtime_error&) {
    // what NLopt makes of an Interrupted
    if (!stop) throw;
  }
}

}  // namespace

std::vector<StageResult> calibrate(const std::string& experiment_path, const std::vector<std::string>& overrides,
                                   const Calibration& calibration, const Published& published, int jobs,
                                   const std::atomic<bool>& stop,
                                   const std::function<void(std::size_t done, std::size_t all)>& progress,
                                   const std::string& flown_file) {
  check_override(experiment_path, overrides, fmt::format("first_replicate={}", calibration.first_replicate),
                 calibration.first_where);
  check_override(experiment_path, overrides, fmt::format("replicates={}", calibration.replicates),
                 calibration.count_where);
  check_fresh({"calibrates", calibration.first_where, calibration.first_replicate, calibration.replicates},
              experiment_path, overrides);
  published.check_vehicle(calibration.table, read_experiment(experiment_path, overrides));
  Evaluations flown(flown_file);
  std::size_t all = 0, before = 0;
  for (const CalibrationStage& stage : calibration.stages) {
    all += static_cast<std::size_t>(stage.evaluations);
    const Objective checked(experiment_path, overrides, calibration, stage, published, jobs, flown);
    for (const OpenParameter& parameter : stage.parameters)
      check_override(experiment_path, overrides, fmt::format("{}={}", parameter.key, config::shortest(parameter.start)),
                     parameter.where);
  }

  std::vector<std::string> held = overrides;
  std::vector<StageResult> results;
  for (const CalibrationStage& stage : calibration.stages) {
    Objective objective(experiment_path, held, calibration, stage, published, jobs, flown);
    std::vector<double> start;
    for (const OpenParameter& parameter : stage.parameters) start.push_back(to_unit(parameter, parameter.start));
    const double start_loss = objective(start);
    std::int64_t used = 1;

    search_stage(objective, start, stage.evaluations, stop,
                 [&] { progress(before + static_cast<std::size_t>(++used), all); });
    if (stop) break;

    objective.best.start_loss = start_loss;
    objective.best.evaluations = used;
    objective.best.share_as_far = objective.share_as_far();
    for (std::string& text : objective.overrides_of(objective.best.values)) held.push_back(std::move(text));
    results.push_back(objective.best);
    before += static_cast<std::size_t>(stage.evaluations);
  }
  return results;
}

}  // namespace gustlab
