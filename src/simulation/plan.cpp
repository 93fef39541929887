// The runs of an experiment, and what each is known by.
#include <fmt/format.h>

#include "config/hash.hpp"
#include "config/toml.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/trajectory.hpp"
#include "simulation/experiment.hpp"
#include "simulation/make_effects.hpp"

namespace gustlab {

namespace {

using config::Hash;

template <class Row>
std::string describe(const Row* row, const EffectSpec& spec) {
  const auto made = row->make();
  config::read_parameters(spec, *made);
  return fmt::format("type = \"{}\"\n{}", row->name, config::canonical_text(*made));
}
std::string describe_trajectory(const Choice& choice) {
  return describe(find_trajectory(choice.spec.type), choice.spec);
}
std::string describe_controller(const Choice& choice) {
  return describe(find_controller(choice.spec.type), choice.spec);
}

std::string describe(const Environment& environment) {
  const auto height = [](const std::optional<double>& z_m) {
    return z_m ? config::shortest(*z_m) : std::string("none");
  };
  std::string text = fmt::format("[environment]\nground_z_m = {}\nceiling_z_m = {}\n", height(environment.ground_z_m),
                                 height(environment.ceiling_z_m));
  for (const Environment::Wall& wall : environment.walls)
    text += fmt::format("wall = [{}, {}, {}, {}]\n", config::shortest(wall.point_W_m.x()),
                        config::shortest(wall.point_W_m.y()), config::shortest(wall.normal_W.x()),
                        config::shortest(wall.normal_W.y()));
  return text;
}

// what all runs of an experiment share
std::string shared_text(const Experiment& experiment) {
  std::string text = "gustlab-run/1\n";
  text += fmt::format("model = \"{}\"\n", to_hex(Hash().add(experiment.vehicle.source_bytes).words()));
  text += fmt::format("seed = {}\n", experiment.seed);
  text += describe(experiment.vehicle.environment);
  FlightOptions flight = experiment.flight;
  text += "[flight]\n" + config::canonical_text(flight);
  for (const NamedEffect& effect : make_flown_effects(experiment.effects))
    text += fmt::format("[[effect]]\ntype = \"{}\"\n{}", effect.row->name, config::canonical_text(*effect.effect));
  return text;
}

}  // namespace

std::string to_hex(const std::array<std::uint64_t, 2>& key) { return fmt::format("{:016x}{:016x}", key[0], key[1]); }

std::vector<RunSpec> plan(const Experiment& experiment) {
  const std::string shared = shared_text(experiment);
  std::vector<std::string> trajectories, controllers;
  for (const Choice& choice : experiment.trajectories)
    trajectories.push_back("[trajectory]\n" + describe_trajectory(choice));
  for (const Choice& choice : experiment.controllers)
    controllers.push_back("[controller]\n" + describe_controller(choice));

  std::vector<RunSpec> runs;
  RunSpec spec;
  for (spec.trajectory = 0; spec.trajectory < trajectories.size(); ++spec.trajectory)
    for (spec.controller = 0; spec.controller < controllers.size(); ++spec.controller) {
      const Hash cell = Hash().add(shared).add(trajectories[spec.trajectory]).add(controllers[spec.controller]);
      for (std::int64_t k = 0; k < experiment.replicates; ++k) {
        spec.replicate = static_cast<std::uint32_t>(experiment.first_replicate + k);
        spec.key = Hash(cell).add(fmt::format("replicate = {}\n", spec.replicate)).words();
        runs.push_back(spec);
        ++spec.index;
      }
    }
  return runs;
}

std::string resolved_text(const Experiment& experiment) {
  std::string text = shared_text(experiment);
  text += fmt::format("name = \"{}\"\nvehicle = \"{}\"\nreplicates = {}\nfirst_replicate = {}\n", experiment.name,
                      experiment.vehicle.name, experiment.replicates, experiment.first_replicate);
  for (const Choice& choice : experiment.trajectories)
    text += fmt::format("[trajectory.{}]\n{}", choice.name, describe_trajectory(choice));
  for (const Choice& choice : experiment.controllers)
    text += fmt::format("[controller.{}]\n{}", choice.name, describe_controller(choice));
  return text;
}

}  // namespace gustlab
