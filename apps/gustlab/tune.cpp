#include "sweep/tune.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

struct Options {
  ExperimentOptions experiment;
  std::string tuning, out;
  int jobs = default_jobs();
};

void tune_command(const Options& options) {
  const std::string path = find_experiment(options.experiment.experiment);
  const Tuning tuning = read_tuning(options.tuning.empty() ? tuning_path(path) : options.tuning);
  check_files_can_be_written(options.out, {"gains.toml"});
  const std::atomic<bool>& stop = interrupted();
  Progress progress;
  const std::vector<TuneResult> results = tune(path, options.experiment.overrides(), tuning, options.jobs, stop,
                                               [&](std::size_t done, std::size_t all) { progress.show(done, all); });
  progress.end();
  if (results.size() < tuning.controllers.size()) throw ExitCode{130};
  std::string command = "gustlab tune " + options.experiment.words();
  if (!options.tuning.empty())
    command += " --tuning " + shell_word(std::filesystem::path(options.tuning).filename().string());
  const std::string text = to_toml(results, tuning, command);
  write_together([&] {
    make_folder(options.out);
    write_file((std::filesystem::path(options.out) / "gains.toml").string(), text);
  });
  fmt::print("{}", text);
}

}  // namespace

void add_tune(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "tune", "gives every controller the same budget of flights in the same gusts, and writes its best gains");
  options->experiment.add_to(*command);
  command->add_option("--tuning", options->tuning, "what may vary; NAME.tuning.toml beside the experiment by default");
  command
      ->add_option("--out", options->out,
                   "folder of gains.toml: [controller.NAME] tables that an experiment can include")
      ->required();
  add_jobs(*command, options->jobs);
  command->callback([options] { tune_command(*options); });
}

}  // namespace gustlab
