#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "commands.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "learning/train_daiml.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"
#include "util/sha256.hpp"

namespace gustlab {

namespace {

struct TrainArguments {
  ExperimentOptions experiment;
  TrainingOptions training;
  std::string out;
  int jobs = default_jobs();
};

double mean_of(const std::vector<double>& values, std::size_t first, std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = first; i < first + count; ++i) sum += values[i] / static_cast<double>(count);
  return sum;
}

// what the weights come from and what they reach, for the file and for the screen
std::vector<std::pair<std::string, std::string>> account(const TrainArguments& options,
                                                         const std::vector<Experiment>& variants,
                                                         const std::vector<Condition>& conditions,
                                                         const Training& training) {
  std::string resolved;
  for (const Experiment& variant : variants) resolved += resolved_text(variant);
  // said also where it was not given, if it is that of all flights, too: --seed is both
  const bool one_seed =
      !options.experiment.seed && std::all_of(variants.begin(), variants.end(), [&](const Experiment& v) {
        return static_cast<std::uint64_t>(v.seed) == options.training.seed;
      });
  const std::size_t epochs = training.prediction.size(), tenth = std::max<std::size_t>(1, epochs / 10);
  const TrainingOptions& t = options.training;
  std::vector<std::pair<std::string, std::string>> lines{
      {"made by", fmt::format("gustlab train {}{} --epochs {} --adversary {}", options.experiment.words(),
                              one_seed ? fmt::format(" --seed {}", t.seed) : "", t.epochs, t.loss.adversary)},
      {"experiment sha256", sha256(resolved)},
      {"vehicle", variants.front().vehicle.name},
      {"prediction loss",
       fmt::format("{:.4g} (m/s^2)^2 in the first tenth of the epochs, {:.4g} in the last",
                   mean_of(training.prediction, 0, tenth), mean_of(training.prediction, epochs - tenth, tenth))},
      {"discriminator",
       fmt::format("right for {:.3f} of the samples, a fresh one on the finished features for {:.3f}, chance {:.3f}; "
                   "cross-entropy {:.3f} nat, of a guess {:.3f}",
                   training.accuracy, training.probe_accuracy, training.chance,
                   mean_of(training.confusion, epochs - tenth, tenth), -std::log(training.chance))}};
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    const ConditionFigures& figures = training.conditions[c];
    lines.emplace_back(fmt::format("{} {}", figures.held_out ? "held out" : "condition", figures.name),
                       fmt::format("{} samples; rms {:.4f} m/s^2, error of the mean {:.4f}, of the network {:.4f}",
                                   conditions[c].samples.inputs.rows(), figures.residual_rms, figures.mean_error,
                                   figures.network_error));
  }
  return lines;
}

void check_conditions(const std::vector<Experiment>& variants, const std::string& path) {
  const auto trained = std::count_if(variants.begin(), variants.end(), [](const Experiment& v) { return !v.held_out; });
  if (trained < 2)
    config::Table::read_file(path).fail("variant", fmt::format("{} wind condition to train on", trained),
                                        "the discriminator tells them apart",
                                        "give at least two [[variant]] tables without held_out");
}

void train(TrainArguments options) {
  interrupted();
  if (options.experiment.seed) options.training.seed = *options.experiment.seed;
  const std::vector<Experiment> variants = options.experiment.read_variants();
  check_conditions(variants, find_experiment(options.experiment.experiment));
  check_file_can_be_written(options.out);
  const std::vector<Condition> conditions = collect(variants, options.jobs);
  Progress progress;
  Training training = train_daiml(conditions, options.training, progress.report());
  progress.end();
  training.network.provenance = account(options, variants, conditions, training);
  write_file(options.out, network_text(training.network));
  for (const auto& [key, value] : training.network.provenance) fmt::print("{}: {}\n", key, value);
}

}  // namespace

void add_train(CLI::App& app) {
  const auto options = std::make_shared<TrainArguments>();
  TrainingOptions& training = options->training;
  CLI::App* command = app.add_subcommand("train",
                                         "learns the features of controller daiml (DAIML) from flights in the wind "
                                         "conditions of an experiment's [[variant]] tables");
  options->experiment.add_to(*command);
  command->add_option("--out", options->out, "WEIGHTS: the network, a text file")->required();
  command->add_option("--epochs", training.epochs, "in each, one step per condition")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_option("--adversary", training.loss.adversary, "alpha: weight of the discriminator in the loss")
      ->check(number_up_to(1e3))
      ->capture_default_str();
  add_jobs(*command, options->jobs);
  command->callback([options] { train(*options); });
}

}  // namespace gustlab
