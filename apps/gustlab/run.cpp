#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "report/tracking_json.hpp"
#include "simulation/recorder.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

struct RunArguments {
  ExperimentOptions experiment;
  std::string trajectory, controller, variant, out;
  std::optional<std::uint32_t> replicate;
};

// which of them has this name; without a name the only one
std::size_t find_choice(const std::vector<Choice>& choices, const std::string& name, const std::string& option) {
  if (name.empty() && choices.size() == 1) return 0;
  std::vector<std::string> known;
  for (const Choice& choice : choices) {
    if (choice.name == name) return known.size();
    known.push_back(choice.name);
  }
  const std::string have = known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "));
  throw ConfigError(worded(
      name.empty() ? fmt::format("{} is missing", option) : fmt::format("{} {}: not in this experiment", option, name),
      "it has " + have, config::suggest(name, known)));
}

// a gust that no sweep of the experiment meets
std::uint32_t find_replicate(const Experiment& experiment, std::optional<std::uint32_t> wanted) {
  const std::int64_t first = experiment.first_replicate, last = first + experiment.replicates - 1;
  if (wanted && (*wanted < first || *wanted > last))
    throw ConfigError(
        fmt::format("--replicate {}: not in this experiment (it has {}); plan it with --set first_replicate and "
                    "replicates",
                    *wanted, first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last)));
  return wanted.value_or(static_cast<std::uint32_t>(first));
}

void run_command(const RunArguments& options) {
  interrupted();
  const Experiment experiment =
      options.variant.empty() ? options.experiment.read() : options.experiment.read_variants({options.variant}).front();
  RunSpec wanted;
  wanted.trajectory = find_choice(experiment.trajectories, options.trajectory, "--trajectory");
  wanted.controller = find_choice(experiment.controllers, options.controller, "--controller");
  wanted.replicate = find_replicate(experiment, options.replicate);

  check_files_can_be_written(options.out, {"flight.csv", "flight.meta.toml", "outcome.json"});
  auto [record, log] = run_logged(experiment, wanted, AtInterrupt::end);
  nlohmann::ordered_json outcome{{"format", "gustlab-outcome/1"},
                                 {"experiment", experiment.name},
                                 {"vehicle", experiment.vehicle.name},
                                 {"trajectory", experiment.trajectories[wanted.trajectory].name},
                                 {"controller", experiment.controllers[wanted.controller].name},
                                 {"replicate", wanted.replicate},
                                 {"outcome", to_string(record.outcome)},
                                 {"duration_s", record.duration_s},
                                 {"settle_s", experiment.flight.settle_s},
                                 {"seed", experiment.seed},
                                 {"set", options.experiment.set}};
  outcome["tracking"] = to_json(record.error);
  write_together([&, &log = log] {
    make_folder(options.out);
    const std::filesystem::path folder(options.out);
    write_run_log(std::move(log), experiment, (folder / "flight.csv").string(), AtInterrupt::end);
    write_file((folder / "outcome.json").string(), config::json_text(outcome, 2) + "\n");
  });
  spdlog::info("{}: {} after {:.3f} s", options.out, to_string(record.outcome), record.duration_s);
}

}  // namespace

void add_run(CLI::App& app) {
  const auto options = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "flies one run into OUT/flight.csv, its sidecar and OUT/outcome.json");
  options->experiment.add_to(*command);
  command->add_option("--trajectory", options->trajectory, "one of the experiment's, if it has more than one");
  command->add_option("--controller", options->controller, "one of the experiment's, if it has more than one");
  command->add_option("--variant", options->variant,
                      "one of the experiment's; without it, what stands outside the [[variant]] tables");
  command->add_option("--replicate", options->replicate,
                      "which of the experiment's seeded gusts; the first by default");
  command->add_option("--out", options->out, "folder of the results")->required();
  command->callback([options] { run_command(*options); });
}

}  // namespace gustlab
