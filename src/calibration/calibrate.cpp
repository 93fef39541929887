#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlopt.hpp>

#include "calibration/calibration.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "sweep/sweep.hpp"

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

std::string quoted_list(const std::vector<std::string>& names) { return fmt::format("[\"{}\"]", fmt::join(names, "\", \"")); }

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

// evaluates one stage at points of the unit cube
class Objective {
 public:
  Objective(const std::string& path, const std::vector<std::string>& overrides, const Calibration& calibration,
            const CalibrationStage& stage, const Published& published, int jobs)
      : path_(path), overrides_(overrides), stage_(stage), jobs_(jobs) {
    std::vector<std::string> trajectories, controllers;
    for (const TargetCell& cell : stage.targets) {
      add_once(trajectories, cell.trajectory);
      add_once(controllers, cell.controller);
      const PublishedRow* row = published.find(calibration.table, cell.trajectory, cell.controller);
      if (row == nullptr)
        throw ConfigError(fmt::format("{}: {} has no row {} {} (a target is a cell that was published)", cell.where, calibration.table,
                                      cell.trajectory, cell.controller));
      published_.push_back(row->figures[cell.metric].mean);
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
    const double loss = fly(at);
    known_.emplace(at, loss);
    if (best.values.empty() || loss < best.loss) {
      best.values = at;
      best.loss = loss;
      best.figures = figures_;
    }
    return loss;
  }

  StageResult best;

 private:
  double fly(const std::vector<double>& at) {
    std::vector<std::string> overrides = overrides_;
    for (std::string& text : overrides_of(at)) overrides.push_back(std::move(text));
    const Experiment experiment = read_experiment(path_, overrides);
    const std::vector<RunSpec> runs = plan(experiment);
    const std::vector<RunRecord> records = fly_all(experiment, runs, jobs_);
    best.flights += static_cast<std::int64_t>(runs.size());

    const auto crashed = std::count_if(records.begin(), records.end(), [](const RunRecord& r) { return r.outcome != Outcome::completed; });
    double loss = crash_loss * static_cast<double>(crashed) / static_cast<double>(records.size());
    figures_.clear();
    for (std::size_t i = 0; i < stage_.targets.size(); ++i) {
      const TargetCell& cell = stage_.targets[i];
      std::vector<double> ours;
      for (const RunRecord& record : records)
        if (experiment.trajectories[record.spec.trajectory].name == cell.trajectory &&
            experiment.controllers[record.spec.controller].name == cell.controller)
          ours.push_back(published_figures(record.error.planar)[cell.metric]);
      figures_.push_back(summarize(ours).mean);
      const double ratio = std::log(figures_.back() / published_[i]);
      loss += ratio * ratio / static_cast<double>(stage_.targets.size());
    }
    return std::isfinite(loss) ? loss : 1e3;
  }

  std::string path_;
  std::vector<std::string> overrides_;
  const CalibrationStage& stage_;
  int jobs_;
  std::vector<double> published_, figures_;
  std::map<std::vector<double>, double> known_;
};

}  // namespace

std::vector<StageResult> calibrate(const std::string& experiment_path, const std::vector<std::string>& overrides,
                                   const Calibration& calibration, const Published& published, int jobs,
                                   const std::atomic<bool>& stop,
                                   const std::function<void(std::size_t done, std::size_t all)>& progress) {
  const Experiment reported = read_experiment(experiment_path, overrides);
  if (calibration.first_replicate < reported.first_replicate + reported.replicates &&
      reported.first_replicate < calibration.first_replicate + calibration.replicates)
    throw ConfigError(fmt::format("{}: calibrates on replicates that are reported ({} to {}) move first_replicate", calibration.where,
                                  reported.first_replicate, reported.first_replicate + reported.replicates - 1));
  std::size_t all = 0, before = 0;
  for (const CalibrationStage& stage : calibration.stages) {
    all += static_cast<std::size_t>(stage.evaluations);
    const Objective checked(experiment_path, overrides, calibration, stage, published, jobs);
    for (const OpenParameter& parameter : stage.parameters)
      check_override(experiment_path, overrides, fmt::format("{}={}", parameter.key, config::shortest(parameter.start)), parameter.where);
  }

  std::vector<std::string> held = overrides;
  std::vector<StageResult> results;
  for (const CalibrationStage& stage : calibration.stages) {
    Objective objective(experiment_path, held, calibration, stage, published, jobs);
    std::vector<double> start;
    for (const OpenParameter& parameter : stage.parameters) start.push_back(to_unit(parameter, parameter.start));
    const double start_loss = objective(start);
    std::int64_t used = 1;

    // Bobyqa wants two dimensions
    nlopt::opt search(start.size() > 1 ? nlopt::LN_BOBYQA : nlopt::LN_SBPLX, static_cast<unsigned>(start.size()));
    auto evaluate = [&](const std::vector<double>& at) {
      if (stop) search.force_stop();
      progress(before + static_cast<std::size_t>(++used), all);
      return objective(at);
    };
    using Evaluate = decltype(evaluate);
    search.set_min_objective(
        [](const std::vector<double>& at, std::vector<double>&, void* data) { return (*static_cast<Evaluate*>(data))(at); }, &evaluate);
    search.set_lower_bounds(0.0);
    search.set_upper_bounds(1.0);
    search.set_initial_step(0.15);
    search.set_xtol_abs(1e-3);
    search.set_maxeval(static_cast<int>(std::max<std::int64_t>(stage.evaluations - 1, 1)));
    try {
      double loss = start_loss;
      search.optimize(start, loss);
    } catch (const nlopt::forced_stop&) {
    } catch (const nlopt::roundoff_limited&) {
      // the loss has steps as fine as three digits: as good as it gets
    }
    if (stop) break;

    objective.best.start_loss = start_loss;
    objective.best.evaluations = used;
    for (std::string& text : objective.overrides_of(objective.best.values)) held.push_back(std::move(text));
    results.push_back(objective.best);
    before += static_cast<std::size_t>(stage.evaluations);
  }
  return results;
}

}  // namespace gustlab
