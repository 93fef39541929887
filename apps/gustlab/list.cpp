#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "control/feature_terms.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/trajectory.hpp"
#include "identification/feature_library.hpp"
#include "identification/optimizer.hpp"
#include "parameter_table.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

using nlohmann::ordered_json;

ordered_json list_vehicles() {
  ordered_json rows = ordered_json::array();
  for (const std::string& name : vehicle_names()) {
    const VehicleModel vehicle = read_vehicle(name);
    rows.push_back({{"name", name},
                    {"says", fmt::format("{} rotors, {:.4g} kg, hovers at {:.4g} rad/s", vehicle.rotor_count,
                                         vehicle.mass_kg, vehicle.hover_speed_radps())},
                    {"mass_kg", vehicle.mass_kg},
                    {"rotors", vehicle.rotor_count}});
  }
  return rows;
}

ordered_json list_controllers() {
  ordered_json rows = ordered_json::array();
  for (const ControllerRow& row : controller_registry())
    rows.push_back(
        {{"name", row.name}, {"says", row.says}, {"source", row.source}, {"parameters", parameter_table(*row.make())}});
  return rows;
}

ordered_json list_trajectories() {
  ordered_json rows = ordered_json::array();
  for (const TrajectoryRow& row : trajectory_registry())
    rows.push_back({{"name", row.name}, {"says", row.says}, {"parameters", parameter_table(*row.make())}});
  return rows;
}

ordered_json list_effects() {
  ordered_json rows = ordered_json::array();
  for (const EffectRow& row : effect_registry())
    rows.push_back({{"name", row.name},
                    {"says", row.says},
                    {"place", to_string(row.place)},
                    {"per_flight", row.per_flight},
                    {"diagnosable", row.diagnosable},
                    {"shows_in", row.shows_in},
                    {"confused_with", row.confused_with},
                    {"source", row.source},
                    {"parameters", parameter_table(*row.make())}});
  return rows;
}

ordered_json list_terms() {
  ordered_json rows = ordered_json::array();
  for (const FeatureVariable& row : feature_variables())
    rows.push_back({{"name", row.name}, {"says", row.says}, {"unit", row.unit}});
  for (const LibraryRow& row : library_registry())
    rows.push_back({{"name", row.name}, {"says", fmt::format("library: {}", row.says)}, {"unit", "-"}});
  return rows;
}

ordered_json list_optimizers() {
  ordered_json rows = ordered_json::array();
  for (const OptimizerRow& row : optimizer_registry()) rows.push_back({{"name", row.name}, {"says", row.says}});
  return rows;
}

struct Kind {
  const char* name;
  ordered_json (*list)();
};
constexpr Kind listings[] = {{"vehicles", list_vehicles},
                             {"controllers", list_controllers},
                             {"trajectories", list_trajectories},
                             {"effects", list_effects},
                             {"terms", list_terms},
                             {"optimizers", list_optimizers}};

struct ListArguments {
  std::string kind;
  std::string format = "text";
};

void run(const ListArguments& options) {
  ordered_json all;
  for (const Kind& kind : listings)
    if (options.kind.empty() || options.kind == kind.name) all[kind.name] = kind.list();
  if (options.format == "json") {
    fmt::print("{}\n", config::json_text(all, 1));
    return;
  }
  for (const auto& [kind, rows] : all.items()) {
    fmt::print("{}{}\n", kind == all.begin().key() ? "" : "\n", kind);
    for (const ordered_json& row : rows)
      fmt::print("  {:20} {}\n", row["name"].get<std::string>(), row["says"].get<std::string>());
  }
}

}  // namespace

void add_list(CLI::App& app) {
  const auto options = std::make_shared<ListArguments>();
  CLI::App* command =
      app.add_subcommand("list", "what there is: vehicles, controllers, trajectories, effects, terms, optimizers");
  std::vector<std::string> names;
  for (const Kind& kind : listings) names.emplace_back(kind.name);
  command->add_option("KIND", options->kind, "one of them (default: all)")->check(CLI::IsMember(names));
  command->add_option("--format", options->format)->check(CLI::IsMember({"text", "json"}))->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace gustlab
