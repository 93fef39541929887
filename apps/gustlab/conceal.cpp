#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "simulation/concealed_trials.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"
#include "util/sha256.hpp"

namespace gustlab {

namespace {

struct ConcealArguments {
  std::string trials, out, answers;
  std::vector<std::string> overrides;
  int jobs = default_jobs();
};

void conceal(const ConcealArguments& options) {
  interrupted();
  check_set_once(options.overrides);
  const TrialsFile file = read_trials_file(options.trials, options.overrides);
  const auto place = [](const std::string& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path));
  };
  if (place(options.answers) == place(options.out))
    throw ConfigError(fmt::format(
        "{}: is the folder of the recordings (the answers are a file); give --answers another name", options.answers));
  check_file_can_be_written(options.answers);
  check_folder_can_be_made(options.out);
  Progress progress;
  std::string answers;
  write_together([&] {
    answers = fly_concealed_trials(file, options.out, options.jobs,
                                   [&](std::size_t done, std::size_t all) { progress.show(done, all, "flights"); });
    write_file(options.answers, answers);
  });
  progress.end();
  std::printf("%s\n", sha256(answers).c_str());
}

}  // namespace

void add_conceal(CLI::App& app) {
  const auto options = std::make_shared<ConcealArguments>();
  CLI::App* command =
      app.add_subcommand("conceal", "flies trials whose vehicle is not quite its model, to test a diagnosis");
  command->add_option("TRIALS", options->trials, "TOML with [[trial]] tables")->required();
  command->add_option("--out", options->out, "folder for the recordings")->required();
  command->add_option("--answers", options->answers, "file for what was concealed; its sha256 is printed")->required();
  command
      ->add_option("--set", options->overrides,
                   "changes a key of the file: key=value with a dotted key, any number of them")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  add_jobs(*command, options->jobs);
  command->callback([options] { conceal(*options); });
}

}  // namespace gustlab
