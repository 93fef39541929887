#include "simulation/concealed_trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "config/json_text.hpp"
#include "config/toml.hpp"
#include "flight_log/trial_kinds.hpp"
#include "gustlab/errors.hpp"
#include "simulation/flight.hpp"
#include "simulation/make_effects.hpp"
#include "simulation/recorder.hpp"
#include "util/files.hpp"
#include "util/parallel.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

constexpr std::string_view trials_format = "gustlab-trials/1";

// columns of a log that each sensor fills
struct Sensor {
  std::string_view name;
  std::vector<std::string_view> columns;
};
const std::array<Sensor, 5>& sensors() {
  static const std::array<Sensor, 5> all{
      {{"pose", {"px", "py", "pz", "qw", "qx", "qy", "qz"}},
       {"velocity", {"vx", "vy", "vz"}},
       {"gyroscope", {"wx", "wy", "wz"}},
       {"accelerometer", {"ax", "ay", "az"}},
       {"rotor_speed", {"rotor1", "rotor2", "rotor3", "rotor4", "rotor5", "rotor6", "rotor7", "rotor8"}}}};
  return all;
}

std::vector<std::string> read_sensors(config::Table& document) {
  const auto names = document.texts("sensors").value_or(std::vector<std::string>{"pose", "velocity", "gyroscope"});
  std::vector<std::string> known;
  for (const Sensor& sensor : sensors()) known.emplace_back(sensor.name);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      document.fail("sensors", fmt::format("\"{}\" is no sensor", name),
                    "one of " + fmt::format("{}", fmt::join(known, ", ")), config::suggest(name, known));
  return names;
}

// the trajectories of a list, by their place in the experiment
std::vector<std::size_t> find_trajectories(const config::Table& table, std::string_view key,
                                           const std::vector<std::string>& names, const Experiment& experiment) {
  std::vector<std::size_t> found;
  std::vector<std::string> known;
  for (const Choice& choice : experiment.trajectories) known.push_back(choice.name);
  for (const std::string& name : names) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      table.fail(key, fmt::format("\"{}\" is not among \"trajectories\"", name), "", config::suggest(name, known));
    found.push_back(static_cast<std::size_t>(at - known.begin()));
  }
  return found;
}

// `effects = [{type = "mass", delta = 0.1}]` or [[trial.effects]]
std::vector<EffectSpec> read_concealed(config::Table& trial) {
  std::vector<EffectSpec> specs;
  for (config::Table& table : trial.tables("effects")) {
    EffectSpec spec;
    spec.type = table.need_text("type");
    spec.where = table.where();
    for (const std::string& key : table.keys()) {
      if (key == "type") continue;
      spec.values.emplace_back(key, *table.literal(key));
      spec.value_where.push_back(table.where(key));
    }
    specs.push_back(std::move(spec));
  }
  make_effects(specs);
  return specs;
}

std::string read_kind(config::Table& trial, std::size_t effects) {
  const std::string kind = trial.text("kind").value_or(trial_kind_of(effects));
  const std::vector<std::string>& known = trial_kinds();
  if (std::find(known.begin(), known.end(), kind) == known.end())
    trial.fail("kind", fmt::format("\"{}\" is no kind of trial", kind),
               "one of " + fmt::format("{}", fmt::join(known, ", ")), config::suggest(kind, known));
  return kind;
}

// a [[trial]] before its experiment is known
struct Draft {
  config::Table table;
  ConcealedTrial trial;
  std::optional<std::string> vehicle;
  std::vector<std::string> fit, holdout;
};

Draft read_draft(config::Table table, const std::vector<std::string>& fit, const std::vector<std::string>& holdout) {
  Draft draft{
      table, {}, table.text("vehicle"), table.texts("fit").value_or(fit), table.texts("holdout").value_or(holdout)};
  draft.trial.name = table.need_text("name");
  draft.trial.concealed = read_concealed(table);
  draft.trial.kind = read_kind(table, draft.trial.concealed.size());
  return draft;
}

// a log as a recording would have it: what the sensors say and the commands, nothing else
FlightLog without_secrets(FlightLog log, const std::vector<std::string>& wanted) {
  std::set<std::string_view> keep;
  for (const Sensor& sensor : sensors())
    if (std::find(wanted.begin(), wanted.end(), sensor.name) != wanted.end())
      keep.insert(sensor.columns.begin(), sensor.columns.end());
  std::erase_if(log.columns, [&](const LogColumn& column) {
    const bool command = column.name.size() == 2 && column.name[0] == 'u';
    return !command && !keep.contains(column.name);
  });
  log.meta.source = "recording";
  return log;
}

struct PlannedFlight {
  const ConcealedTrial* trial;
  RunSpec spec;
  std::string file;  // fit_1.csv
};

FlightLog fly_one(const PlannedFlight& planned) {
  const Experiment& experiment = planned.trial->experiment;
  LoggedRun flown = run_logged(experiment, planned.spec, AtInterrupt::end);
  const RunRecord& end = flown.record;
  if (end.outcome != Outcome::completed)
    throw ConfigError(
        fmt::format("trial \"{}\": {} {} at {:.1f} s (what it conceals is more than the controller can take); use less",
                    planned.trial->name, planned.file, to_string(end.outcome), end.duration_s));
  return std::move(flown.log);
}

std::string answer(const ConcealedTrial& trial) {
  nlohmann::ordered_json line{{"trial", trial.name}, {"vehicle", trial.experiment.vehicle.name}, {"kind", trial.kind}};
  line["effects"] = nlohmann::ordered_json::array();
  for (const EffectSpec& spec : trial.concealed) {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
    for (const auto& [key, literal] : spec.values) {
      // a TOML number is a JSON number, save for its underscores and its infinities
      const nlohmann::ordered_json value = nlohmann::ordered_json::parse(literal, nullptr, false);
      if (value.is_number()) parameters[key] = value;
    }
    line["effects"].push_back({{"effect", spec.type}, {"parameters", parameters}});
  }
  return config::json_text(line) + "\n";
}

// whatever else is in a trial's folder would be taken for its own: an old diagnosis is scored, an old recording diagnosed
void check_nothing_else_is_there(const std::vector<PlannedFlight>& flights, const std::filesystem::path& out) {
  std::map<std::filesystem::path, std::set<std::string>> written;
  for (const PlannedFlight& flight : flights)
    written[out / flight.trial->name].insert({flight.file, sidecar_path(flight.file)});
  for (const auto& [folder, names] : written) {
    std::error_code error;
    std::vector<std::string> others;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
      if (names.count(entry.path().filename().string()) == 0 && !remove_if_left_beside(entry.path().string()))
        others.push_back(entry.path().filename().string());
    if (!others.empty())
      throw ConfigError(
          fmt::format("{}: is there already (it would be taken for a part of this trial); name another folder",
                      (folder / *std::min_element(others.begin(), others.end())).string()));
  }
}

}  // namespace

TrialsFile read_trials_file(const std::string& path, const std::vector<std::string>& overrides) {
  config::Table document = config::Table::read_file(path, overrides);
  if (document.need_text("format") != trials_format)
    document.fail("format", "not a list of trials", fmt::format("\"format\" must be \"{}\"", trials_format), "");
  std::vector<config::Table> tables = document.tables("trial");
  if (tables.empty()) document.fail("", "there is no [[trial]]", "nothing would be flown", "add one");
  TrialsFile file;
  file.sensors = read_sensors(document);
  const auto fit = document.texts("fit").value_or(std::vector<std::string>{});
  const auto holdout = document.texts("holdout").value_or(std::vector<std::string>{});
  const std::vector<EffectSpec> room = config::read_effects(document);

  // every key of a trial is asked for before the document as a whole is finished
  std::vector<Draft> drafts;
  std::set<std::string> seen;
  for (const config::Table& table : tables) {
    drafts.push_back(read_draft(table, fit, holdout));
    const std::string& name = drafts.back().trial.name;
    if (!seen.insert(name).second || name.find_first_of("/\\ ") != std::string::npos)
      table.fail("name", fmt::format("\"{}\" is no name of a folder of its own", name), "", "use another");
  }
  Experiment base = make_experiment(document, path);
  base.speed_is_logged = std::find(file.sensors.begin(), file.sensors.end(), "rotor_speed") != file.sensors.end();
  for (Draft& draft : drafts) {
    ConcealedTrial& trial = draft.trial;
    trial.experiment = base;
    if (draft.vehicle) {
      trial.experiment.vehicle_name = *draft.vehicle;
      trial.experiment.vehicle = read_vehicle(*draft.vehicle, path);
      trial.experiment.vehicle.environment = base.vehicle.environment;
      trial.experiment.effects = config::merge_effects(trial.experiment.vehicle.effects, room);
    }
    trial.experiment.effects = config::merge_effects(trial.experiment.effects, trial.concealed);
    trial.fit = find_trajectories(draft.table, "fit", draft.fit, base);
    trial.holdout = find_trajectories(draft.table, "holdout", draft.holdout, base);
    if (trial.fit.empty()) draft.table.fail("fit", "there is no flight to fit", "", "list trajectories under \"fit\"");
    file.trials.push_back(std::move(trial));
  }
  return file;
}

std::string fly_concealed_trials(const TrialsFile& file, const std::string& out, int jobs,
                                 const std::function<void(std::size_t, std::size_t)>& progress) {
  std::vector<PlannedFlight> flights;
  std::string answers;
  // every flight has air of its own
  std::uint32_t replicate = 0;
  for (const ConcealedTrial& trial : file.trials) {
    const auto add = [&](const std::vector<std::size_t>& trajectories, const char* role) {
      for (std::size_t i = 0; i < trajectories.size(); ++i)
        flights.push_back({&trial, {0, trajectories[i], 0, ++replicate, {}}, fmt::format("{}_{}.csv", role, i + 1)});
    };
    add(trial.fit, "fit");
    add(trial.holdout, "holdout");
    answers += answer(trial);
  }
  check_nothing_else_is_there(flights, out);
  for (const PlannedFlight& flight : flights) check_log_rows(flight.trial->experiment, flight.spec);

  std::vector<FlightLog> logs(flights.size());
  std::mutex counting;
  std::size_t flown = 0;
  parallel_for(static_cast<std::int64_t>(flights.size()), jobs, [&](std::int64_t i) {
    const auto n = static_cast<std::size_t>(i);
    logs[n] = without_secrets(fly_one(flights[n]), file.sensors);
    const std::lock_guard<std::mutex> lock(counting);
    ++flown;
    if (progress) progress(flown, flights.size());
  });
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const std::filesystem::path folder = std::filesystem::path(out) / flights[i].trial->name;
    make_folder(folder.string());
    write_run_log(std::move(logs[i]), flights[i].trial->experiment, (folder / flights[i].file).string(),
                  AtInterrupt::end);
  }
  return answers;
}

}  // namespace gustlab
