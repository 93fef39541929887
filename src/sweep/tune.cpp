#include "sweep/tune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlopt.hpp>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "sweep/fresh_replicates.hpp"
#include "sweep/sweep.hpp"

namespace gustlab {

namespace {

constexpr double uncompleted_m = 10.0;  // the error that a flight counts as when it is not completed

// the search moves in [0, 1]; values have four digits, so that a table of them says all
double value_of(const TunedParameter& parameter, double share) {
  const double value = parameter.logarithmic ? parameter.min * std::pow(parameter.max / parameter.min, share)
                                             : parameter.min + share * (parameter.max - parameter.min);
  return std::clamp(std::stod(fmt::format("{:.4g}", value)), parameter.min, parameter.max);
}
double share_of(const TunedParameter& parameter, double value) {
  return parameter.logarithmic ? std::log(value / parameter.min) / std::log(parameter.max / parameter.min)
                               : (value - parameter.min) / (parameter.max - parameter.min);
}

// the loss of one controller as a function of its parameters; every new point costs flights, a known one none
class Objective {
 public:
  Objective(const std::string& path, std::vector<std::string> overrides, const Tuning& tuning, const Tuning::Controller& controller, int jobs)
      : path_(path), overrides_(std::move(overrides)), controller_(controller), jobs_(jobs) {
    overrides_.push_back(fmt::format("controllers=[\"{}\"]", controller.name));
    overrides_.push_back(fmt::format("first_replicate={}", tuning.first_replicate));
    overrides_.push_back(fmt::format("replicates={}", tuning.replicates));
    best.controller = controller.name;
    best.loss = std::numeric_limits<double>::infinity();
  }

  double operator()(const std::vector<double>& shares) {
    std::vector<double> values;
    for (std::size_t i = 0; i < shares.size(); ++i) values.push_back(value_of(controller_.parameters[i], shares[i]));
    const auto [known, is_new] = known_.try_emplace(values, 0.0);
    if (is_new) known->second = fly(values);
    if (known->second < best.loss) {
      best.loss = known->second;
      best.values = values;
      best_shares = shares;
    }
    return known->second;
  }

  TuneResult best;
  std::vector<double> best_shares;

 private:
  double fly(const std::vector<double>& values) {
    std::vector<std::string> overrides = overrides_;
    for (std::size_t i = 0; i < values.size(); ++i)
      overrides.push_back(fmt::format("controller.{}.{}={}", controller_.name, controller_.parameters[i].name, config::shortest(values[i])));
    const Experiment experiment = read_experiment(path_, overrides);
    const std::vector<RunSpec> runs = plan(experiment);
    best.flights += static_cast<std::int64_t>(runs.size());
    double sum = 0.0;
    for (const RunRecord& record : fly_all(experiment, runs, jobs_))
      sum += std::log(record.outcome == Outcome::completed ? std::min(uncompleted_m, record.error.spatial.rmse_m) : uncompleted_m);
    return sum / static_cast<double>(runs.size());
  }

  std::string path_;
  std::vector<std::string> overrides_;
  const Tuning::Controller& controller_;
  int jobs_;
  std::map<std::vector<double>, double> known_;
};

TunedParameter read_parameter(config::Table table) {
  TunedParameter parameter{table.need_text("name"), table.need_number("min"), table.need_number("max"), table.need_number("start"),
                           table.flag("log").value_or(false), table.where("name")};
  if (!(parameter.min < parameter.max && parameter.min <= parameter.start && parameter.start <= parameter.max))
    table.fail("start", "\"min\", \"start\" and \"max\" are out of order", "the search starts inside its range", "");
  if (parameter.logarithmic && !(parameter.min > 0.0)) table.fail("min", "\"min\" has no logarithm", "log = true", "write a number above zero");
  return parameter;
}

// what the search would stumble over later
void check_controllers(const std::string& path, const std::vector<std::string>& overrides, const Tuning& tuning) {
  for (const Tuning::Controller& controller : tuning.controllers) {
    std::vector<std::string> settings = overrides;
    const std::string alone = fmt::format("controllers=[\"{}\"]", controller.name);
    check_override(path, settings, alone, controller.where);
    settings.push_back(alone);
    for (const TunedParameter& parameter : controller.parameters)
      check_override(path, settings, fmt::format("controller.{}.{}={}", controller.name, parameter.name, config::shortest(parameter.start)), parameter.where);
    settings.push_back(fmt::format("replicates={}", tuning.replicates));
    if (const std::size_t runs = plan(read_experiment(path, settings)).size(); static_cast<std::size_t>(tuning.flights) < runs)
      throw ConfigError(fmt::format("{}: a budget of {} flights does not pay for one evaluation of {} ({} flights: replicates times trajectories)",
                                    tuning.flights_where, tuning.flights, controller.name, runs));
  }
}

}  // namespace

std::string tuning_path(const std::string& experiment_path) {
  return experiment_path.substr(0, experiment_path.rfind(".toml")) + ".tuning.toml";
}

Tuning read_tuning(const std::string& path) {
  config::Table document = config::Table::read_file(path);
  if (document.need_text("format") != "gustlab-tuning/1") document.fail("format", "this is no tuning", "", "write format = \"gustlab-tuning/1\"");
  Tuning tuning;
  const auto count = [&](std::string_view key, std::int64_t value) { return document.integer(key).value_or(value); };
  const auto where = [&](std::string_view key) { return document.where(document.has(key) ? key : ""); };
  tuning.flights_where = where("flights");
  tuning.replicates_where = where("first_replicate");
  tuning.flights = count("flights", tuning.flights);
  tuning.first_replicate = count("first_replicate", tuning.first_replicate);
  tuning.replicates = count("replicates", tuning.replicates);
  tuning.search_seed = count("search_seed", tuning.search_seed);
  for (config::Table& table : document.tables("controller")) {
    Tuning::Controller& controller = tuning.controllers.emplace_back();
    controller.name = table.need_text("name");
    controller.where = table.where("name");
    for (config::Table& parameter : table.tables("parameters")) controller.parameters.push_back(read_parameter(parameter));
    if (controller.parameters.empty()) table.fail("parameters", "\"parameters\" is empty", "there is nothing to tune", "");
  }
  if (tuning.controllers.empty()) document.fail("controller", "there is no [[controller]]", "nothing would be tuned", "add one");
  document.finish();
  // only now: a misspelt key is not a missing one
  for (const auto& [key, value] : {std::pair{"flights", tuning.flights}, {"first_replicate", tuning.first_replicate},
                                   {"replicates", tuning.replicates}, {"search_seed", tuning.search_seed}})
    if (constexpr std::int64_t most = 1000000000; value > most)
      document.fail(key, fmt::format("\"{}\" is out of range", key), fmt::format("{} is more than {}", value, most), "");
    else if (value < 1) document.fail(key, fmt::format("\"{}\" is {}", key, document.has(key) ? "not positive" : "missing"), "", "");
  return tuning;
}

std::vector<TuneResult> tune(const std::string& experiment_path, const std::vector<std::string>& overrides, const Tuning& tuning, int jobs,
                             const std::atomic<bool>& stop, const std::function<void(std::size_t done, std::size_t all)>& progress) {
  check_fresh({"tunes", tuning.replicates_where, tuning.first_replicate, tuning.replicates}, experiment_path, overrides);
  check_controllers(experiment_path, overrides, tuning);
  std::vector<TuneResult> results;
  for (const Tuning::Controller& controller : tuning.controllers) {
    Objective objective(experiment_path, overrides, tuning, controller, jobs);
    std::vector<double> start;
    for (const TunedParameter& parameter : controller.parameters) start.push_back(share_of(parameter, parameter.start));
    const double start_loss = objective(start);
    // as many new points as the budget has flights for
    const std::int64_t flights = objective.best.flights, most = tuning.flights / flights * flights;

    const auto search = [&](nlopt::algorithm algorithm, std::vector<double> at, std::int64_t until) {
      nlopt::opt optimizer(algorithm, static_cast<unsigned>(at.size()));
      auto evaluate = [&](const std::vector<double>& shares) {
        if (stop || objective.best.flights >= until) optimizer.force_stop();
        else progress(results.size() * static_cast<std::size_t>(most) + static_cast<std::size_t>(objective.best.flights),
                      tuning.controllers.size() * static_cast<std::size_t>(most));
        return objective.best.flights >= until ? objective.best.loss : objective(shares);
      };
      using Evaluate = decltype(evaluate);
      optimizer.set_lower_bounds(0.0);
      optimizer.set_upper_bounds(1.0);
      optimizer.set_initial_step(0.1);
      optimizer.set_maxeval(static_cast<int>(20 * most / flights));
      optimizer.set_min_objective(
          [](const std::vector<double>& shares, std::vector<double>&, void* data) { return (*static_cast<Evaluate*>(data))(shares); }, &evaluate);
      double loss = 0.0;
      try {
        optimizer.set_xtol_abs(1e-4);
        optimizer.optimize(at, loss);
      } catch (const nlopt::forced_stop&) {
      } catch (const UserError&) {
        throw;
      } catch (const std::runtime_error&) {
        // NLopt gives up where nothing moves any more: four digits of a parameter are as fine as it gets
      }
    };
    nlopt::srand(static_cast<unsigned long>(tuning.search_seed));
    search(nlopt::GN_CRS2_LM, start, most / 2);
    search(nlopt::LN_SBPLX, objective.best_shares, most);
    if (stop) break;
    objective.best.start_loss = start_loss;
    results.push_back(objective.best);
  }
  return results;
}

std::string to_toml(const std::vector<TuneResult>& results, const Tuning& tuning, const std::string& experiment) {
  std::string text = fmt::format("# written by `gustlab tune {}`: at most {} flights per controller, replicates {} to {}, search seed {}\n",
                                 experiment, tuning.flights, tuning.first_replicate, tuning.first_replicate + tuning.replicates - 1, tuning.search_seed);
  for (std::size_t k = 0; k < results.size(); ++k) {
    const TuneResult& result = results[k];
    text += fmt::format("\n# {} flights; geometric mean of the RMS error in space {:.4f} m, at the start {:.4f} m\n[controller.{}]\n", result.flights,
                        std::exp(result.loss), std::exp(result.start_loss), result.controller);
    for (std::size_t i = 0; i < result.values.size(); ++i)
      text += fmt::format("{} = {}\n", tuning.controllers[k].parameters[i].name, config::shortest(result.values[i]));
  }
  return text;
}

}  // namespace gustlab
