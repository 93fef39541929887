#include "simulation/experiment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "config/resources.hpp"
#include "config/text.hpp"
#include "config/toml.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/trajectory.hpp"
#include "simulation/flight.hpp"
#include "simulation/setting_units.hpp"
#include "simulation/variants.hpp"
#include "util/files.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

constexpr std::string_view experiment_format = "gustlab-experiment/1";

// everything that stands outside the tables of the file
class ExperimentKeys final : public Parameterized {
 public:
  std::string format{experiment_format}, name, vehicle;
  std::vector<std::string> trajectories, controllers, include;
  std::int64_t replicates = 1, first_replicate = 1, seed = 1;
  FlightOptions flight;
  LogOptions log;

  void visit(ParameterVisitor& visitor) override {
    visitor.text("format", format, {});
    visitor.text("name", name, {.help = "what results call it"});
    visitor.text("vehicle", vehicle, {.help = "name under models/, or path of a vehicle.toml"});
    visitor.texts("trajectories", trajectories,
                  {.help = "see `gustlab list trajectories`; parameters in [trajectory.NAME]"});
    visitor.texts("controllers", controllers,
                  {.help = "see `gustlab list controllers`; parameters in [controller.NAME]"});
    visitor.integer("replicates", replicates, {.help = "seeded runs of each cell", .min = 1, .max = 1e6});
    visitor.integer("first_replicate", first_replicate, {.help = "number of the first", .min = 0, .max = 4e9});
    visitor.integer("seed", seed, {.help = "of every random stream", .min = 0});
    visitor.texts("include", include,
                  {.help = "files with [[effect]] and [controller.NAME] tables, relative to this one"});
    flight.visit(visitor);
    log.visit(visitor);
  }
};

// parameters of one name in [trajectory.NAME] or [controller.NAME]; `type` is the name unless given
Choice read_choice(const std::string& name, std::optional<config::Table> table, const std::string& where) {
  if (table) return {name, config::read_spec(*table, table->text("type").value_or(name))};
  Choice choice{name, {}};
  choice.spec.type = name;
  choice.spec.where = where;
  return choice;
}

// what an included file says of a choice holds where the experiment says nothing
void lay_under(Choice& choice, const std::vector<Choice>& included) {
  EffectSpec& spec = choice.spec;
  for (const Choice& below : included) {
    if (below.name != choice.name) continue;
    if (spec.type == choice.name) spec.type = below.spec.type;
    spec.value_where.resize(spec.values.size(), spec.where);
    for (std::size_t i = 0; i < below.spec.values.size(); ++i) {
      const auto& value = below.spec.values[i];
      if (std::any_of(spec.values.begin(), spec.values.end(),
                      [&](const auto& own) { return own.first == value.first; }))
        continue;
      spec.values.push_back(value);
      spec.value_where.push_back(below.spec.value_where[i]);
    }
  }
}

// the choices of a kind, in the order of the list `key`, each known to `registry`
template <class Registry>
std::vector<Choice> read_choices(config::Table& document, std::string_view kind, std::string_view key,
                                 const std::vector<std::string>& names, const Registry& registry,
                                 const std::vector<Choice>& included = {}) {
  std::vector<std::string> known;
  for (const auto& row : registry) known.emplace_back(row.name);
  const auto check_type = [&](const Choice& choice) {
    if (std::find(known.begin(), known.end(), choice.spec.type) != known.end()) return;
    std::string near = config::suggest(choice.spec.type, known);
    // a name of the field that is not ours: what a row says of itself may have it
    for (const auto& row : registry)
      if (near.empty() && choice.spec.type.size() > 3 &&
          config::lower(row.says).find(config::lower(choice.spec.type)) != std::string::npos)
        near = fmt::format("did you mean \"{}\"?", row.name);
    throw ConfigError(worded(fmt::format("{}: unknown {} \"{}\"", choice.spec.where, kind, choice.spec.type),
                             near.empty() ? fmt::format("see `gustlab list {}`", key) : "", near));
  };

  std::optional<config::Table> tables = document.table(kind);
  std::vector<Choice> choices;
  std::set<std::string> seen;
  if (names.empty())
    document.fail(key, fmt::format("\"{}\" is empty", key), "there is nothing to fly", fmt::format("name a {}", kind));
  for (const std::string& name : names) {
    check_name(document, key, name);
    if (!seen.insert(name).second) document.fail(key, fmt::format("\"{}\" is here twice", name), "", "keep one");
    choices.push_back(read_choice(name, tables ? tables->table(name) : std::nullopt, document.where(key)));
    lay_under(choices.back(), included);
    check_type(choices.back());
  }
  // tables of choices that this list leaves out are checked too
  if (tables)
    for (const std::string& name : tables->keys())
      if (seen.count(name) == 0) check_type(read_choice(name, tables->table(name), tables->where(name)));
  return choices;
}

// what an error says of a setting that a file asks for, as if it stood on the command line; nothing when it is about another
std::optional<std::string> said_of(const std::string& setting, const ConfigError& error) {
  const std::string said = error.what(), prefix = "--set " + setting + ": ";
  return said.starts_with(prefix) ? std::optional(said.substr(prefix.size())) : std::nullopt;
}

// what the files of the list `include` say
struct Included {
  std::vector<EffectSpec> effects;
  std::vector<Choice> controllers;
};
Included read_included(config::Table& experiment, const std::string& path, std::vector<EffectSpec> effects) {
  Included included{std::move(effects), {}};
  for (const std::string& file : experiment.texts("include").value_or(std::vector<std::string>{})) {
    const std::string beside = (std::filesystem::path(path).parent_path() / file).string();
    std::string text;
    if (const std::string why = read_into(beside, text); !why.empty())
      experiment.fail("include", fmt::format("\"{}\" cannot be read", beside), why, "");
    config::Table document = config::Table::parse(text, beside);
    document.text("format");
    document.text("vehicle");
    included.effects = config::merge_effects(included.effects, config::read_effects(document));
    if (std::optional<config::Table> tables = document.table("controller"))
      for (const std::string& name : tables->keys())
        included.controllers.push_back(read_choice(name, tables->table(name), ""));
    document.finish();
  }
  return included;
}

// leaves the variants of these names, or all when there is none
void choose(std::vector<Variant>& variants, const std::vector<std::string>& only, const std::string& path) {
  std::vector<std::string> known;
  for (const Variant& variant : variants) known.push_back(variant.name);
  for (const std::string& name : only)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw ConfigError(
          worded(fmt::format("{}: there is no variant \"{}\"", path, name),
                 fmt::format("it has {}", known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))),
                 config::suggest(name, known)));
  if (!only.empty())
    std::erase_if(variants, [&](const Variant& variant) {
      return std::find(only.begin(), only.end(), variant.name) == only.end();
    });
}

// an override above what a variant sets would make variants alike
void check_not_lost(const std::vector<std::string>& overrides, const std::vector<Variant>& variants) {
  for (const std::string& text : overrides)
    for (const Variant& variant : variants)
      for (const std::string& setting : variant.set)
        if (const std::string own = key_of_both(text, setting); !own.empty())
          throw ConfigError(
              fmt::format("--set {}: variant \"{}\" sets {} itself ({}; its value would be lost); fly others with "
                          "--variant, or change the file",
                          text, variant.name, own, variant.where));
}

// a flight of each trajectory and each controller is made once, so that what does not fit shows before anything runs
void check_flights(const Experiment& experiment, const config::Table& document) {
  RunSpec spec;
  try {
    for (spec.trajectory = 0; spec.trajectory < experiment.trajectories.size(); ++spec.trajectory)
      for (spec.controller = 0; spec.controller < experiment.controllers.size(); ++spec.controller)
        Flight(experiment, spec);
  } catch (const ParameterError& error) {
    document.fail(error.parameter, error.what(), "", "");
  }
}

}  // namespace

void FlightOptions::visit(ParameterVisitor& visitor) {
  visitor.number("duration_s", duration_s,
                 {.unit = "s", .help = "of the manoeuvre; 0: as long as the trajectory says", .min = 0.0, .max = 1e5});
  visitor.number(
      "laps", laps,
      {.help = "of the trajectory, in the place of \"duration_s\"; 0: that decides", .min = 0.0, .max = 1e4});
  visitor.number("hover_before_s", hover_before_s,
                 {.unit = "s", .help = "the reference first stands where the vehicle starts", .min = 0.0, .max = 1e4});
  visitor.number("hover_after_s", hover_after_s,
                 {.unit = "s", .help = "the reference last stands where the manoeuvre ends", .min = 0.0, .max = 1e4});
  visitor.number("hand_over_s", hand_over_s,
                 {.unit = "s",
                  .help = "until then the vehicle's own position loop flies (controller pid with its defaults)",
                  .min = 0.0,
                  .max = 1e4});
  visitor.number("step_s", step_s,
                 {.unit = "s", .help = "plant step; divides every controller period", .min = 1e-5, .max = 0.02});
  visitor.number("settle_s", settle_s, {.unit = "s", .help = "samples before it do not count", .min = 0.0});
  visitor.number("offboard_rate_hz", offboard_rate_hz,
                 {.unit = "Hz",
                  .help = "rate at which position, velocity and reference reach the controller; 0: every tick",
                  .min = 0.0});
  visitor.number("offboard_delay_s", offboard_delay_s,
                 {.unit = "s",
                  .help = "age at which position and velocity reach the controller, over the same link",
                  .min = 0.0,
                  .max = 1.0});
  visitor.number(
      "offboard_jitter_s", offboard_jitter_s,
      {.unit = "s",
       .help = "what a message of the link may be later than that, uniformly; one that is overtaken is dropped",
       .min = 0.0,
       .max = 1.0});
  visitor.number(
      "offboard_dropout", offboard_dropout,
      {.unit = "-", .help = "share of the messages that are lost; set points hold then, too", .min = 0.0, .max = 0.99});
  visitor.text("set_points", set_points,
               {.help = "what of the reference reaches the controller: full, or position (and heading) alone"});
  visitor.number("max_error_m", max_error_m,
                 {.unit = "m", .help = "farther from the reference: left_envelope", .min = 0.0});
  visitor.number("max_speed_mps", max_speed_mps, {.unit = "m/s", .help = "faster: left_envelope", .min = 0.0});
}

void LogOptions::visit(ParameterVisitor& visitor) {
  visitor.number("log_rate_hz", log_rate_hz,
                 {.unit = "Hz", .help = "rows of a flight log; 0: every control tick", .min = 0.0});
  visitor.text("log_source", log_source, {.help = "sensors: what was measured; truth: the simulator's state"});
}

std::unique_ptr<Parameterized> make_experiment_keys() { return std::make_unique<ExperimentKeys>(); }

std::string find_experiment(const std::string& name_or_path) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (fs::exists(name_or_path, error) || name_or_path.find_first_of("/.") != std::string::npos) return name_or_path;
  std::vector<std::string> known;
  for (const fs::path& home : resource_homes()) {
    const fs::path file = home / "experiments" / (name_or_path + ".toml");
    if (fs::exists(file, error)) return file.string();
    for (const auto& entry : fs::directory_iterator(home / "experiments", error))
      if (entry.path().extension() == ".toml" && entry.path().stem().extension().empty())
        known.push_back(entry.path().stem().string());
  }
  const std::string near = fs::exists(name_or_path + ".toml", error)
                               ? fmt::format("did you mean \"{}.toml\"?", name_or_path)
                               : config::suggest(name_or_path, known);
  throw ConfigError(worded(name_or_path + ": no such file, and no such name under experiments/", "", near));
}

Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides) {
  config::Table document = config::Table::read_file(path, overrides);
  if (document.need_text("format") != experiment_format)
    document.fail("format", "not an experiment of this program",
                  fmt::format("\"format\" must be \"{}\"", experiment_format), "");
  return make_experiment(document, path);
}

void check_override(const std::string& path, std::vector<std::string> overrides, const std::string& setting,
                    const std::string& where) {
  overrides.push_back(setting);
  try {
    read_experiment(path, overrides);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("{}: {}", where, said_of(setting, error).value_or(error.what())));
  }
}

std::vector<Experiment> read_variants(const std::string& path, const std::vector<std::string>& overrides,
                                      const std::vector<std::string>& only) {
  config::Table document = config::Table::read_file(path);
  std::vector<Variant> variants = read_variant_tables(document);
  choose(variants, only, path);
  if (variants.empty()) return {read_experiment(path, overrides)};
  check_not_lost(overrides, variants);
  std::vector<Experiment> experiments;
  for (const Variant& variant : variants) {
    std::vector<std::string> set = variant.set;
    set.insert(set.end(), overrides.begin(), overrides.end());
    try {
      experiments.push_back(read_experiment(path, set));
    } catch (const ConfigError& error) {
      for (const std::string& setting : variant.set)
        if (const auto said = said_of(setting, error)) throw ConfigError(fmt::format("{}: {}", variant.where, *said));
      throw;
    }
    Experiment& experiment = experiments.back();
    experiment.name += "." + variant.name;
    experiment.variant = variant.name;
    experiment.variant_place = variant.place;
    experiment.variants = variants.size();
    experiment.axes = variant.axes;
    for (const NamedValue& axis : variant.axis_keys)
      if (const std::string unit = unit_of_setting(experiment, axis.value); !unit.empty())
        experiment.axis_units.push_back({axis.name, unit});
    experiment.alone = variant.alone;
    experiment.held_out = variant.held_out;
  }
  return experiments;
}

Experiment make_experiment(config::Table& document, const std::string& path) {
  document.need_text("vehicle");
  check_name(document, "name", document.need_text("name"));
  const auto trajectory_names = document.texts("trajectories").value_or(std::vector<std::string>{});
  const auto controller_names = document.texts("controllers").value_or(std::vector<std::string>{});

  Experiment experiment;
  experiment.trajectories =
      read_choices(document, "trajectory", "trajectories", trajectory_names, trajectory_registry());
  experiment.vehicle_name = document.need_text("vehicle");
  experiment.vehicle = read_vehicle(experiment.vehicle_name, path);
  const Included included = read_included(document, path, experiment.vehicle.effects);
  experiment.controllers = read_choices(document, "controller", "controllers", controller_names, controller_registry(),
                                        included.controllers);
  const std::vector<EffectSpec> own_effects = config::read_effects(document);
  const bool has_environment = document.has("environment");
  const Environment environment = config::read_environment(document);
  read_variant_tables(document);
  ExperimentKeys keys;
  config::read_parameters(document, keys);

  experiment.name = keys.name;
  experiment.replicates = keys.replicates;
  experiment.first_replicate = keys.first_replicate;
  experiment.seed = keys.seed;
  experiment.flight = keys.flight;
  experiment.log = keys.log;
  if (keys.log.log_source != "sensors" && keys.log.log_source != "truth")
    document.fail("log_source", fmt::format("\"{}\" is no source", keys.log.log_source), "",
                  "write \"sensors\" or \"truth\"");
  if (keys.flight.duration_s > 0.0 && keys.flight.settle_s >= keys.flight.duration_s)
    document.fail("settle_s", "\"settle_s\" leaves nothing to measure", "it is not shorter than \"duration_s\"", "");

  if (has_environment) experiment.vehicle.environment = environment;
  experiment.effects = config::merge_effects(included.effects, own_effects);
  check_flights(experiment, document);
  return experiment;
}

}  // namespace gustlab
