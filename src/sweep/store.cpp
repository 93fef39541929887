#include "sweep/store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <sstream>

#include "config/text.hpp"
#include "config/toml.hpp"
#include "gustlab/build_info.hpp"
#include "gustlab/errors.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

constexpr const char* schema = R"(
CREATE TABLE provenance(name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE plan(run INTEGER PRIMARY KEY, trajectory TEXT NOT NULL, controller TEXT NOT NULL, replicate INTEGER NOT NULL,
                  key TEXT NOT NULL);
CREATE TABLE flown(run INTEGER PRIMARY KEY REFERENCES plan(run), outcome TEXT NOT NULL, duration_s REAL, rmse_xy_m REAL,
                   mae_xy_m REAL, p95_xy_m REAL, max_xy_m REAL, rmse_z_m REAL, rotor_sd_radps REAL, rotor_rate_radps2 REAL);
CREATE VIEW runs AS SELECT trajectory, controller, replicate, outcome, duration_s, rmse_xy_m, mae_xy_m, p95_xy_m, max_xy_m,
                           rmse_z_m, key, rotor_sd_radps, rotor_rate_radps2 FROM plan JOIN flown USING (run) ORDER BY run;
)";

// what decides the last bits of a result beside the program: libm picks its code by these
std::string cpu_features() {
  std::string features;
  const auto add = [&](bool has, const char* name) {
    if (has) features += (features.empty() ? "" : " ") + std::string(name);
  };
#if defined(__x86_64__)
  add(__builtin_cpu_supports("sse4.2"), "sse4.2");
  add(__builtin_cpu_supports("avx"), "avx");
  add(__builtin_cpu_supports("avx2"), "avx2");
  add(__builtin_cpu_supports("fma"), "fma");
  add(__builtin_cpu_supports("avx512f"), "avx512f");
#elif defined(__aarch64__)
  add(true, "aarch64");
#endif
  return features;
}

// one name=value a line
std::string to_lines(const std::vector<NamedValue>& values) {
  std::string text;
  for (const NamedValue& value : values) text += fmt::format("{}={}\n", value.name, value.value);
  return text;
}
std::vector<NamedValue> from_lines(const std::string& text) {
  std::vector<NamedValue> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    values.push_back({line.substr(0, line.find('=')), line.substr(line.find('=') + 1)});
  return values;
}

// a resolved configuration, line by line: "seed = 1", "[trajectory.circle] period_s = 5"
std::vector<std::string> settings_of(const std::string& resolved) {
  std::vector<std::string> settings;
  std::string table;
  std::istringstream lines(resolved);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("[")) table = line + " ";
    settings.push_back(line.starts_with("[") ? line : table + line);
    // effects have their type in the place of a name
    if (line.starts_with("type = ") && table.starts_with("[[")) table += line.substr(7) + " ";
    // behind the tables that all runs share stand keys of none
    if (line.starts_with("name = ")) settings.back() = line, table.clear();
  }
  return settings;
}

}  // namespace

Provenance provenance_of(const Experiment& experiment, const Shard& shard) {
  const BuildInfo& build = build_info();
  return {{"experiment", resolved_text(experiment)},
          {"name", experiment.name},
          {"vehicle", experiment.vehicle.name},
          {"settle_s", config::shortest(experiment.flight.settle_s)},
          {"arcs", to_lines(arcs_of(experiment))},
          {"axes", to_lines(experiment.axes)},
          {"axis_units", to_lines(experiment.axis_units)},
          {"variant_place", fmt::format("{}", experiment.variant_place)},
          {"variants", fmt::format("{}", experiment.variants)},
          {"version", std::string(build.version)},
          {"commit", std::string(build.commit)},
          {"mujoco", std::string(build.mujoco_version)},
          {"compiler", std::string(build.compiler)},
          {"flags", std::string(build.flags)},
          {"shard", fmt::format("{}/{}", shard.part, shard.parts)},
          {"cpu", cpu_features()}};
}

std::vector<std::string> differences(const Provenance& a, const Provenance& b) {
  std::vector<std::string> names;
  for (const auto& [name, value] : a) {
    const auto other = b.find(name);
    if (name != "shard" && name != "cpu" && name != "variant_place" && name != "variants" &&
        (other == b.end() || other->second != value))
      names.push_back(name);
  }
  return names;
}

std::string experiment_difference(const Provenance& there, const Provenance& here) {
  if (there.at("experiment") == here.at("experiment")) return "";
  for (const char* name : {"name", "vehicle"})
    if (there.at(name) != here.at(name))
      return fmt::format("its {} is {} there, {} here", name, there.at(name), here.at(name));
  const std::vector<std::string> a = settings_of(there.at("experiment")), b = settings_of(here.at("experiment"));
  const auto [one, other] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  const auto said = [](const auto& at, const auto& end) { return at == end ? std::string("nothing more") : *at; };
  if (one != a.end() && one->starts_with("model = ")) return "the files of its vehicle differ";
  return fmt::format("{} there, {} here", said(one, a.end()), said(other, b.end()));
}

RunStore::RunStore(const std::string& path, Database::Mode mode) : database_(path, mode) {
  if (mode != Database::Mode::read)
    // a cache of 256 kB: the memory of a sweep does not grow with its flights (docs/PERFORMANCE.md)
    for (const char* setting :
         {"locking_mode = EXCLUSIVE", "journal_mode = WAL", "synchronous = NORMAL", "cache_size = -256"})
      database_.run(fmt::format("PRAGMA {}", setting));
  Statement tables = database_.prepare(
      "SELECT count(*), total(name IN ('provenance', 'plan', 'flown')) FROM sqlite_master "
      "WHERE type = 'table'");
  tables.step();
  if (tables.integer(0) == 0) return;
  if (tables.integer(1) != 3) throw DataError(fmt::format("{}: not a result store of this program", path));
  Statement all = database_.prepare("SELECT name, value FROM provenance");
  while (all.step()) provenance_[all.text(0)] = all.text(1);
  for (const char* name : {"experiment", "name", "vehicle", "settle_s", "version", "commit", "mujoco", "compiler",
                           "flags", "shard", "cpu", "arcs", "axes", "variant_place"})
    if (!provenance_.contains(name))
      throw DataError(
          fmt::format("{}: not a result store of this program (\"{}\" is not in its provenance)", path, name));
  const std::string& settle_s = provenance_.at("settle_s");
  const char* end = settle_s.data() + settle_s.size();
  if (const auto [rest, error] = std::from_chars(settle_s.data(), end, settle_s_); error != std::errc() || rest != end)
    throw DataError(
        fmt::format("{}: \"settle_s\" of the provenance is no number ({})", path, config::quoted(settle_s)));
}

void RunStore::write_provenance(const Provenance& provenance) {
  database_.run("DELETE FROM provenance");
  Statement insert = database_.prepare("INSERT INTO provenance VALUES (?, ?)");
  for (const auto& [name, value] : provenance) insert.bind(0, name).bind(1, value).step();
  provenance_ = provenance;
}

void RunStore::begin(const Provenance& provenance, const Experiment& experiment, const Plan& plan) {
  database_.run("BEGIN");
  database_.run(schema);
  Statement insert = database_.prepare("INSERT INTO plan VALUES (?, ?, ?, ?, ?)");
  for (std::size_t run = 0; run < plan.size(); ++run) {
    const RunSpec spec = plan[run];
    insert.bind(0, static_cast<std::int64_t>(run))
        .bind(1, experiment.trajectories[spec.trajectory].name)
        .bind(2, experiment.controllers[spec.controller].name)
        .bind(3, std::int64_t{spec.replicate})
        .bind(4, to_hex(spec.key))
        .step();
  }
  write_provenance(provenance);
  database_.run("COMMIT");
}

std::vector<bool> RunStore::done() {
  std::vector<bool> done;
  Statement all =
      database_.prepare("SELECT flown.run IS NOT NULL, run FROM plan LEFT JOIN flown USING (run) ORDER BY run");
  while (all.step()) {
    if (all.integer(1) != static_cast<std::int64_t>(done.size()))
      throw DataError(fmt::format("{}: run {} is not in the plan of this store (it was changed by another program)",
                                  database_.path(), done.size()));
    done.push_back(all.integer(0) != 0);
  }
  if (done.empty())
    throw DataError(
        fmt::format("{}: no run is planned in this store (it was changed by another program)", database_.path()));
  return done;
}

void RunStore::add(const RunRecord& record) {
  if (!insert_) insert_ = database_.prepare("INSERT INTO flown VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  const ErrorFigures& planar = record.error.planar;
  insert_->bind(0, static_cast<std::int64_t>(record.spec.index))
      .bind(1, to_string(record.outcome))
      .bind(2, record.duration_s);
  insert_->bind(3, planar.rmse_m).bind(4, planar.mae_m).bind(5, planar.p95_m).bind(6, planar.max_m);
  insert_->bind(7, record.error.rmse_z_m)
      .bind(8, record.effort.speed_sd_radps)
      .bind(9, record.effort.acceleration_radps2)
      .step();
}

void RunStore::start_over(const Provenance& provenance) {
  database_.run("BEGIN; DELETE FROM flown");
  write_provenance(provenance);
  database_.run("COMMIT");
}

void RunStore::copy_plan(RunStore& from, const Provenance& provenance) {
  database_.run("BEGIN");
  database_.run(schema);
  Statement all = from.database_.prepare("SELECT run, trajectory, controller, replicate, key FROM plan");
  Statement insert = database_.prepare("INSERT INTO plan VALUES (?, ?, ?, ?, ?)");
  while (all.step()) {
    insert.bind(0, all.integer(0))
        .bind(1, all.text(1))
        .bind(2, all.text(2))
        .bind(3, all.integer(3))
        .bind(4, all.text(4));
    insert.step();
  }
  write_provenance(provenance);
  database_.run("COMMIT");
}

void RunStore::take_runs(RunStore& from) {
  database_.run("BEGIN");
  Statement all = from.database_.prepare("SELECT * FROM flown");
  Statement insert = database_.prepare("INSERT INTO flown VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  while (all.step()) {
    throw_if_interrupted();
    insert.bind(0, all.integer(0)).bind(1, all.text(1));
    for (int column = 2; column < 10; ++column) insert.bind(column, all.number(column));
    insert.step();
  }
  database_.run("COMMIT");
}

std::string RunStore::name_of(std::size_t run) {
  Statement one = database_.prepare("SELECT trajectory, controller, replicate FROM plan WHERE run = ?");
  one.bind(0, static_cast<std::int64_t>(run)).step();
  return fmt::format("{} {} {}", one.text(0), one.text(1), one.integer(2));
}

void RunStore::for_each(const std::function<void(ResultRow)>& use) {
  const std::vector<NamedValue> axes = from_lines(provenance_.at("axes"));
  Statement all = database_.prepare("SELECT * FROM runs");
  while (all.step()) {
    ResultRow row;
    row.experiment = provenance_.at("name");
    row.vehicle = provenance_.at("vehicle");
    row.trajectory = all.text(0);
    row.controller = all.text(1);
    const bool is_counted = all.is_number(2);
    row.replicate = all.integer(2);
    const auto wrong = [&](const std::string& problem) {
      return DataError(
          fmt::format("{}: {} {} {}: {}", database_.path(), row.trajectory, row.controller, all.text(2), problem));
    };
    if (!is_counted) throw wrong("this replicate is no number");
    const auto outcome = find_outcome(all.text(3));
    if (!outcome) throw wrong(fmt::format("\"{}\" is no outcome", all.text(3)));
    row.outcome = *outcome;
    int column = 4;
    const auto figure = [&](double& value) {
      const bool is_number = all.is_number(column);
      value = all.number(column);
      if (!is_number || !is_figure(value))
        throw wrong(
            fmt::format("{} of {} is no figure of a flight", config::quoted(all.text(column)), all.name(column)));
      ++column;
    };
    for (double* value : {&row.duration_s, &row.rmse_xy_m, &row.mae_xy_m, &row.p95_xy_m, &row.max_xy_m, &row.rmse_z_m})
      figure(*value);
    row.key = all.text(column++);
    for (double* value : {&row.rotor_sd_radps, &row.rotor_rate_radps2}) figure(*value);
    row.axes = axes;
    use(std::move(row));
  }
}

Results RunStore::results() {
  Results results;
  results.settle_s = settle_s_;
  results.arcs = from_lines(provenance_.at("arcs"));
  // stores of earlier programs have no units
  if (const auto units = provenance_.find("axis_units"); units != provenance_.end())
    results.axis_units = from_lines(units->second);
  for_each([&](ResultRow row) { results.rows.push_back(std::move(row)); });
  return results;
}

void RunStore::close() {
  insert_.reset();
  database_.run("PRAGMA journal_mode = DELETE");
  // a reader that found a log that was not closed leaves this, and nobody needs it now
  std::error_code ignored;
  std::filesystem::remove(database_.path() + "-shm", ignored);
}

}  // namespace gustlab
