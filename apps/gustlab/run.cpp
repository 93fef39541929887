#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "report/tracking_json.hpp"
#include "simulation/recorder.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

struct Options {
  ExperimentOptions experiment;
  std::string trajectory, controller, out;
  std::optional<std::uint32_t> replicate;
};

std::size_t find_choice(const std::vector<Choice>& choices, const std::string& name, const std::string& option) {
  std::vector<std::string> known;
  for (const Choice& choice : choices) {
    if (choice.name == name) return known.size();
    known.push_back(choice.name);
  }
  throw ConfigError(fmt::format("{} {}: not in this experiment (it has {}) {}", option, name, fmt::join(known, ", "), config::suggest(name, known)));
}

void run_command(const Options& options) {
  const Experiment experiment = options.experiment.read();
  RunSpec wanted;
  wanted.trajectory = find_choice(experiment.trajectories, options.trajectory, "--trajectory");
  wanted.controller = find_choice(experiment.controllers, options.controller, "--controller");
  wanted.replicate = options.replicate.value_or(static_cast<std::uint32_t>(experiment.first_replicate));

  Flight flight(experiment, wanted);
  TrackingError error(flight.options.settle_s, static_cast<std::size_t>(flight.ticks));
  FlightRecorder recorder(experiment, flight);
  const FlightEnd end = fly(flight, error, &recorder);

  nlohmann::ordered_json outcome{{"format", "gustlab-outcome/1"},
                                 {"experiment", experiment.name},
                                 {"vehicle", experiment.vehicle.name},
                                 {"trajectory", options.trajectory},
                                 {"controller", options.controller},
                                 {"replicate", wanted.replicate},
                                 {"outcome", to_string(end.outcome)},
                                 {"duration_s", end.time_s},
                                 {"settle_s", flight.options.settle_s}};
  outcome["tracking"] = to_json(error.figures());
  make_folder(options.out);
  const std::filesystem::path folder(options.out);
  write_flight_log(recorder.take(), (folder / "flight.csv").string());
  write_file((folder / "outcome.json").string(), outcome.dump(2) + "\n");
  spdlog::info("{}: {} after {:.3f} s", options.out, to_string(end.outcome), end.time_s);
}

}  // namespace

void add_run(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("run", "flies one run into OUT/flight.csv, its sidecar and OUT/outcome.json");
  options->experiment.add_to(*command);
  command->add_option("--trajectory", options->trajectory, "one of the experiment's")->required();
  command->add_option("--controller", options->controller, "one of the experiment's")->required();
  command->add_option("--replicate", options->replicate, "which of the seeded gusts; the experiment's first by default");
  command->add_option("--out", options->out, "folder of the results")->required();
  command->callback([options] { run_command(*options); });
}

}  // namespace gustlab
