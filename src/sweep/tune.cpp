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
  Objective(const std::string& path, std::vector<std::string> overrides, const Tuning& tuning,
            const Tuning::Controller& controller, int jobs)
      : path_(path),
        overrides_(std::move(overrides)),
        scenarios_(tuning.scenarios),
        controller_(controller),
        jobs_(jobs) {
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

  std::vector<double> start() const {
    std::vector<double> shares;
    for (const TunedParameter& parameter : controller_.parameters)
      shares.push_back(share_of(parameter, parameter.start));
    return shares;
  }

  TuneResult best;
  std::vector<double> best_shares;

 private:
  double fly(const std::vector<double>& values) {
    std::vector<std::string> overrides = overrides_;
    for (std::size_t i = 0; i < values.size(); ++i)
      overrides.push_back(fmt::format("controller.{}.{}={}", controller_.name, controller_.parameters[i].name,
                                      config::shortest(values[i])));
    double sum = 0.0, flights = 0.0;
    for (const std::vector<std::string>& scenario : scenarios_) {
      std::vector<std::string> set = scenario;
      set.insert(set.end(), overrides.begin(), overrides.end());
      const Experiment experiment = read_experiment(path_, set);
      for (const RunRecord& record : fly_all(experiment, plan(experiment), jobs_)) {
        sum +=
            record.outcome == Outcome::completed ? std::min(uncompleted_m, record.error.planar.rmse_m) : uncompleted_m;
        flights += 1.0;
      }
    }
    best.flights += static_cast<std::int64_t>(flights);
    return sum / flights;
  }

  std::string path_;
  std::vector<std::string> overrides_;
  const std::vector<std::vector<std::string>>& scenarios_;
  const Tuning::Controller& controller_;
  int jobs_;
  std::map<std::vector<double>, double> known_;
};

TunedParameter read_parameter(config::Table table) {
  TunedParameter parameter{table.need_text("name"),    table.need_number("min"),          table.need_number("max"),
                           table.need_number("start"), table.flag("log").value_or(false), table.where("name")};
  if (!(parameter.min < parameter.max && parameter.min <= parameter.start && parameter.start <= parameter.max))
    table.fail("start", "\"min\", \"start\" and \"max\" are out of order", "the search starts inside its range", "");
  if (parameter.logarithmic && !(parameter.min > 0.0))
    table.fail("min", "\"min\" has no logarithm", "log = true", "write a number above zero");
  return parameter;
}

// what the search would stumble over later
void check_controllers(const std::string& path, const std::vector<std::string>& overrides, const Tuning& tuning) {
  std::vector<std::string> listed;
  for (const Choice& choice : read_experiment(path, overrides).controllers) listed.push_back(choice.name);
  for (const Tuning::Controller& controller : tuning.controllers) {
    std::vector<std::string> settings = overrides;
    const std::string alone = fmt::format("controllers=[\"{}\"]", controller.name);
    check_override(path, settings, alone, controller.where);
    if (std::find(listed.begin(), listed.end(), controller.name) == listed.end())
      throw ConfigError(worded(
          fmt::format("{}: \"{}\" is none of the controllers of the experiment", controller.where, controller.name),
          fmt::format("it has {}", fmt::join(listed, ", ")), "add it to \"controllers\", or leave it out here"));
    settings.push_back(alone);
    for (const TunedParameter& parameter : controller.parameters)
      check_override(
          path, settings,
          fmt::format("controller.{}.{}={}", controller.name, parameter.name, config::shortest(parameter.start)),
          parameter.where);
    settings.push_back(fmt::format("replicates={}", tuning.replicates));
    std::size_t runs = 0;
    for (const std::vector<std::string>& scenario : tuning.scenarios) {
      std::vector<std::string> set = scenario;
      set.insert(set.end(), settings.begin(), settings.end());
      runs += plan(read_experiment(path, set)).size();
    }
    if (static_cast<std::size_t>(tuning.flights) < runs)
      throw ConfigError(
          fmt::format("{}: a budget of {} flights does not pay for one evaluation of {} ({} flights: replicates times "
                      "trajectories times scenarios)",
                      tuning.flights_where, tuning.flights, controller.name, runs));
  }
}

}  // namespace

std::string tuning_path(const std::string& experiment_path) {
  return experiment_path.substr(0, experiment_path.rfind(".toml")) + ".tuning.toml";
}

Tuning read_tuning(const std::string& path) {
  config::Table document = config::Table::read_file(path);
  if (document.need_text("format") != "gustlab-tuning/1")
    document.fail("format", "this is no tuning", "", "write format = \"gustlab-tuning/1\"");
  Tuning tuning;
  const auto count = [&](std::string_view key, std::int64_t value) { return document.integer(key).value_or(value); };
  const auto where = [&](std::string_view key) { return document.where(document.has(key) ? key : ""); };
  tuning.flights_where = where("flights");
  tuning.replicates_where = where("first_replicate");
  tuning.flights = count("flights", tuning.flights);
  tuning.first_replicate = count("first_replicate", tuning.first_replicate);
  tuning.replicates = count("replicates", tuning.replicates);
  if (const auto seeds = document.numbers("search_seeds")) tuning.search_seeds.assign(seeds->begin(), seeds->end());
  if (tuning.search_seeds.empty())
    document.fail("search_seeds", "\"search_seeds\" is empty", "every search has one", "");
  const std::vector<config::Table> scenarios = document.tables("scenario");
  if (!scenarios.empty()) tuning.scenarios.clear();
  for (config::Table scenario : scenarios)
    tuning.scenarios.push_back(scenario.texts("set").value_or(std::vector<std::string>{}));
  for (config::Table& table : document.tables("controller")) {
    Tuning::Controller& controller = tuning.controllers.emplace_back();
    controller.name = table.need_text("name");
    controller.where = table.where("name");
    for (config::Table& parameter : table.tables("parameters"))
      controller.parameters.push_back(read_parameter(parameter));
    if (controller.parameters.empty())
      table.fail("parameters", "\"parameters\" is empty", "there is nothing to tune", "");
  }
  if (tuning.controllers.empty())
    document.fail("controller", "there is no [[controller]]", "nothing would be tuned", "add one");
  document.finish();
  // only now: a misspelt key is not a missing one
  for (const auto& [key, value] : {std::pair{"flights", tuning.flights},
                                   {"first_replicate", tuning.first_replicate},
                                   {"replicates", tuning.replicates}})
    if (constexpr std::int64_t most = 1000000000; value > most)
      document.fail(key, fmt::format("\"{}\" is out of range", key), fmt::format("{} is more than {}", value, most),
                    "");
    else if (value < 1)
      document.fail(key, fmt::format("\"{}\" is {}", key, document.has(key) ? "not positive" : "missing"), "", "");
  return tuning;
}

namespace {

// one search of one controller; progress gets its flights
TuneResult search_once(Objective& objective, const Tuning& tuning, std::int64_t search_seed,
                       const std::atomic<bool>& stop, const std::function<void(std::int64_t flights)>& progress) {
  const double start_loss = objective(objective.start());
  // as many new points as the budget has flights for
  const std::int64_t flights = objective.best.flights, most = tuning.flights / flights * flights;
  const auto search = [&](nlopt::algorithm algorithm, std::vector<double> at, std::int64_t until) {
    nlopt::opt optimizer(algorithm, static_cast<unsigned>(at.size()));
    auto evaluate = [&](const std::vector<double>& shares) {
      if (stop || objective.best.flights >= until) optimizer.force_stop();
      else progress(objective.best.flights);
      return objective.best.flights >= until ? objective.best.loss : objective(shares);
    };
    using Evaluate = decltype(evaluate);
    optimizer.set_lower_bounds(0.0);
    optimizer.set_upper_bounds(1.0);
    optimizer.set_initial_step(0.1);
    optimizer.set_maxeval(static_cast<int>(20 * most / flights));
    optimizer.set_min_objective([](const std::vector<double>& shares, std::vector<double>&,
                                   void* data) { return (*static_cast<Evaluate*>(data))(shares); },
                                &evaluate);
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
  nlopt::srand(static_cast<unsigned long>(search_seed));
  search(nlopt::GN_CRS2_LM, objective.start(), most / 2);
  search(nlopt::LN_SBPLX, objective.best_shares, most);
  objective.best.start_loss = start_loss;
  return objective.best;
}

// the names of the parameters that ended on a bound of what was searched, as a comment
std::string bounds_text(const Tuning::Controller& controller, const std::vector<double>& values) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] == controller.parameters[i].min || values[i] == controller.parameters[i].max)
      names.push_back(controller.parameters[i].name);
  return names.empty() ? "" : fmt::format("# on a bound of what was searched: {}\n", fmt::join(names, ", "));
}

}  // namespace

std::vector<TuneResult> tune(const std::string& experiment_path, const std::vector<std::string>& overrides,
                             const Tuning& tuning, int jobs, const std::atomic<bool>& stop,
                             const std::function<void(std::size_t done, std::size_t all)>& progress) {
  check_fresh({"tunes", tuning.replicates_where, tuning.first_replicate, tuning.replicates}, experiment_path,
              overrides);
  check_controllers(experiment_path, overrides, tuning);
  const auto budget = static_cast<std::size_t>(tuning.flights);
  std::vector<TuneResult> results;
  std::size_t searches = 0;
  for (const Tuning::Controller& controller : tuning.controllers) {
    TuneResult best;
    for (const std::int64_t seed : tuning.search_seeds) {
      Objective objective(experiment_path, overrides, tuning, controller, jobs);
      const TuneResult found = search_once(objective, tuning, seed, stop, [&](std::int64_t flights) {
        progress(searches * budget + static_cast<std::size_t>(flights),
                 tuning.controllers.size() * tuning.search_seeds.size() * budget);
      });
      if (stop) return results;
      ++searches;
      std::vector<double> losses = std::move(best.seed_losses);
      losses.push_back(found.loss);
      const std::int64_t flights = best.flights + found.flights;
      if (losses.size() == 1 || found.loss < best.loss) best = found;
      best.seed_losses = std::move(losses);
      best.flights = flights;
    }
    results.push_back(best);
  }
  return results;
}

std::string to_toml(const std::vector<TuneResult>& results, const Tuning& tuning, const std::string& command) {
  std::string text = fmt::format(
      "# written by `{}`: {} searches of at most {} flights per controller, replicates {} to {}, {} "
      "scenarios\n",
      command, tuning.search_seeds.size(), tuning.flights, tuning.first_replicate,
      tuning.first_replicate + tuning.replicates - 1, tuning.scenarios.size());
  for (std::size_t k = 0; k < results.size(); ++k) {
    const TuneResult& result = results[k];
    std::vector<std::string> losses;
    for (const double loss : result.seed_losses) losses.push_back(fmt::format("{:.4f}", loss));
    text += fmt::format(
        "\n# {} flights; mean planar RMSE {} m (one for each search), at the start {:.4f} m\n{}[controller.{}]\n",
        result.flights, fmt::join(losses, ", "), result.start_loss, bounds_text(tuning.controllers[k], result.values),
        result.controller);
    for (std::size_t i = 0; i < result.values.size(); ++i)
      text += fmt::format("{} = {}\n", tuning.controllers[k].parameters[i].name, config::shortest(result.values[i]));
  }
  return text;
}

}  // namespace gustlab
