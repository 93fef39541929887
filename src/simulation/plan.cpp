// The runs of an experiment, and what each is known by.
#include "simulation/plan.hpp"

#include <fmt/format.h>

#include "config/toml.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/trajectory.hpp"
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

Plan::Plan(const Experiment& experiment)
    : controllers_(experiment.controllers.size()),
      replicates_(static_cast<std::size_t>(experiment.replicates)),
      first_replicate_(experiment.first_replicate) {
  const Hash shared = Hash().add(shared_text(experiment));
  std::vector<std::string> controllers;
  for (const Choice& choice : experiment.controllers)
    controllers.push_back("[controller]\n" + describe_controller(choice));
  for (const Choice& choice : experiment.trajectories) {
    const Hash trajectory = Hash(shared).add("[trajectory]\n" + describe_trajectory(choice));
    for (const std::string& controller : controllers) cells_.push_back(Hash(trajectory).add(controller));
  }
}

RunSpec Plan::operator[](std::size_t index) const {
  const std::size_t cell = index / replicates_;
  RunSpec spec;
  spec.index = index;
  spec.trajectory = cell / controllers_;
  spec.controller = cell % controllers_;
  spec.replicate = static_cast<std::uint32_t>(first_replicate_ + static_cast<std::int64_t>(index % replicates_));
  spec.key = Hash(cells_[cell]).add(fmt::format("replicate = {}\n", spec.replicate)).words();
  return spec;
}

std::vector<RunSpec> plan(const Experiment& experiment) {
  const Plan all(experiment);
  std::vector<RunSpec> runs;
  runs.reserve(all.size());
  for (std::size_t index = 0; index < all.size(); ++index) runs.push_back(all[index]);
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
