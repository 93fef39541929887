// Tuning: every controller of an experiment gets the same number of simulated flights in the same gusts.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "simulation/experiment.hpp"

namespace gustlab {

struct TunedParameter {
  std::string name;  // of a number of the controller
  double min = 0.0, max = 1.0, start = 0.5;
  bool logarithmic = false;  // searched on a logarithmic scale
  std::string where = {};    // file:line:col
};

// NAME.tuning.toml, beside NAME.toml.
struct Tuning {
  std::int64_t flights = 0;             // budget of each controller in each search
  std::int64_t first_replicate = 1001;  // of the gusts that are tuned on
  std::int64_t replicates = 4;
  std::vector<std::int64_t> search_seeds{1};  // searches of each controller; the best counts
  std::vector<std::vector<std::string>> scenarios{
      {}};  // [[scenario]]: key=value lists that are flown alike; the mean counts
  struct Controller {
    std::string name;  // one of the experiment's list
    std::vector<TunedParameter> parameters;
    std::string where = {};  // file:line:col
  };
  std::vector<Controller> controllers;
  std::string flights_where = {}, replicates_where = {};  // file:line:col
};
// Throws ConfigError with file:line:col.
Tuning read_tuning(const std::string& path);
std::string tuning_path(const std::string& experiment_path);

// What the searches came to. The loss is what tables report, the mean over the flights of the planar root mean square of the tracking
// error (m); a flight that is not completed counts as 10 m.
struct TuneResult {
  std::string controller;
  std::vector<double> values;  // in the order of the parameters, of the best search
  std::int64_t flights = 0;    // of all searches
  double start_loss = 0.0, loss = 0.0;
  std::vector<double> seed_losses{};  // of each search
};

// NLopt: controlled random search (Kaelo & Ali, JOTA 130, 2006) with half the budget, then Subplex (Rowan 1990) from the best.
// The same values for any number of threads. Throws ConfigError, before anything flies, when replicates
// are tuned on that the experiment, or one of its variants, reports, or that are among the tables' 1 to 10, when the
// experiment knows no such controller or parameter, or when the budget does not pay for a single evaluation.
std::vector<TuneResult> tune(const std::string& experiment_path, const std::vector<std::string>& overrides,
                             const Tuning& tuning, int jobs, const std::atomic<bool>& stop,
                             const std::function<void(std::size_t done, std::size_t all)>& progress);

// [controller.NAME] tables that an experiment can include, which say what command made them.
std::string to_toml(const std::vector<TuneResult>& results, const Tuning& tuning, const std::string& command);

}  // namespace gustlab
