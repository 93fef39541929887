#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "config/resources.hpp"
#include "config/toml.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/trajectory.hpp"
#include "parameter_table.hpp"
#include "simulation/experiment.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

// Something with declared parameters, and how an experiment writes it.
struct Entry {
  std::string kind, name, says, head;
  std::unique_ptr<Parameterized> target;
};

std::vector<Entry> entries() {
  std::vector<Entry> result;
  result.push_back({"experiment", "experiment",
                    "the keys of an experiment outside its tables; those are [trajectory.NAME], [controller.NAME], "
                    "[[effect]], [environment] "
                    "(ground_z_m, ceiling_z_m, walls: what is not given is not there, and nothing crashes into it), "
                    "[[variant]] and [[axis]]",
                    "", make_experiment_keys()});
  for (const TrajectoryRow& row : trajectory_registry())
    result.push_back({"trajectory", std::string(row.name), std::string(row.says),
                      fmt::format("[trajectory.{}]\n", row.name), row.make()});
  for (const ControllerRow& row : controller_registry())
    result.push_back({"controller", std::string(row.name), fmt::format("{} ({})", row.says, row.source),
                      fmt::format("[controller.{}]\n", row.name), row.make()});
  for (const EffectRow& row : effect_registry())
    result.push_back({"effect", std::string(row.name), fmt::format("{} ({})", row.says, row.source),
                      fmt::format("[[effect]]\ntype = \"{}\"\n", row.name), row.make()});
  return result;
}

// files that users write, commented, under configs/templates/
constexpr std::string_view templates[] = {"vehicle", "sidecar", "column-map"};

void print_template(const std::string& name) {
  fmt::print("{}", read_file<ConfigError>(find_resource("configs/templates/" + name + ".toml")));
}

struct DefaultsArguments {
  std::string name;
  std::string format = "toml";
};

void run(const DefaultsArguments& options) {
  std::vector<std::string> names(std::begin(templates), std::end(templates));
  if (std::find(names.begin(), names.end(), options.name) != names.end()) {
    if (options.format != "toml")
      throw ConfigError(fmt::format("defaults {}: is a commented file (there is no {} of it); leave --format out",
                                    options.name, options.format));
    return print_template(options.name);
  }
  bool found = false;
  for (const Entry& entry : entries()) {
    names.push_back(entry.name);
    if (entry.name != options.name) continue;
    if (options.format == "toml") {
      fmt::print("{}# {}\n{}{}", found ? "\n" : "", entry.says, entry.head, config::commented_text(*entry.target));
    } else {
      const nlohmann::ordered_json json{{"kind", entry.kind},
                                        {"name", entry.name},
                                        {"says", entry.says},
                                        {"parameters", parameter_table(*entry.target)}};
      fmt::print("{}\n", config::json_text(json, 1));
    }
    found = true;
  }
  if (const std::string near = config::suggest(options.name, names); !found)
    throw ConfigError(
        worded(fmt::format("defaults {}: there is nothing of this name", options.name), "see `gustlab list`", near));
}

}  // namespace

void add_defaults(CLI::App& app) {
  const auto options = std::make_shared<DefaultsArguments>();
  CLI::App* command = app.add_subcommand(
      "defaults", "a commented TOML: every parameter of an effect, trajectory or controller, or a file to begin with");
  command
      ->add_option("NAME", options->name,
                   "an effect, a trajectory, a controller, or one of experiment, vehicle, sidecar, column-map")
      ->required();
  command->add_option("--format", options->format)->check(CLI::IsMember({"toml", "json"}))->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace gustlab
