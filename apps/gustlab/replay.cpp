#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include "commands.hpp"
#include "config/toml.hpp"
#include "diagnosis/recording/stretches.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "progress.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"
#include "vehicle/gaps.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

struct ReplayArguments {
  std::vector<std::string> flights;
  std::string vehicle, with;
  std::vector<double> horizon_s{0.1, 0.5, 1.0};
  int stride = 0;
  int jobs = default_jobs();
  std::string format = "text";
};

void check_horizons(const std::vector<double>& horizon_s) {
  for (std::size_t h = 0; h < horizon_s.size(); ++h)
    if (!std::isfinite(horizon_s[h]) || horizon_s[h] <= (h > 0 ? horizon_s[h - 1] : 0.0))
      throw ConfigError(
          fmt::format("--horizon: {} s does not belong there (horizons are positive and rise)", horizon_s[h]));
}

// what a prediction starts from is kept, is led on by the model, by the model with effects; what sensors leave at the least
std::string_view in_words(std::string_view kind) {
  if (kind == "hold") return "values kept";
  if (kind == "before") return "model";
  if (kind == "after") return "with effects";
  return kind == "noise" ? "noise alone" : kind;
}

void print_text(const nlohmann::ordered_json& block) {
  fmt::print("{} windows; mean error at the horizon\n\n{:16} {:>9}", block["windows"].get<std::size_t>(), "",
             "horizon_s");
  std::vector<std::string> kinds;
  for (const auto& [kind, values] : block["position_m"].items()) {
    kinds.push_back(kind);
    fmt::print(" {:>12}", in_words(kind));
  }
  fmt::print("\n");
  for (const std::string_view name : diagnosis::fit_quantity_names) {
    const nlohmann::ordered_json& quantity = block[std::string(name)];
    for (std::size_t h = 0; h < block["horizon_s"].size(); ++h) {
      fmt::print("{:16} {:>9g}", h == 0 ? name : "", block["horizon_s"][h].get<double>());
      for (const std::string& kind : kinds) {
        const nlohmann::ordered_json& value = quantity[kind][h];
        fmt::print(" {:>12}", value.is_null() ? "-" : fmt::format("{:.4g}", value.get<double>()));
      }
      fmt::print("\n");
    }
  }
}

void run(const ReplayArguments& options) {
  interrupted();
  check_horizons(options.horizon_s);
  std::optional<std::vector<EffectSpec>> with;
  if (!options.with.empty()) {
    config::Table document = config::Table::read_file(options.with);
    with = config::read_effects(document);
    document.finish();
    // `effect = []` says that there is none, as a diagnosis that found nothing does
    if (!document.has("effect"))
      document.fail("", "there is no [[effect]]", "nothing to compare",
                    "name the augmented.toml of a diagnosis, or leave --with out");
  }
  std::optional<VehicleModel> named;
  if (!options.vehicle.empty()) named = read_vehicle(options.vehicle);
  diagnosis::ReplayOptions wanted;
  wanted.horizon_s = options.horizon_s;
  wanted.stride = options.stride;
  wanted.jobs = options.jobs;

  std::vector<diagnosis::FitErrors> before, after;
  double assumed_V = 0.0;
  std::set<std::string> warned;
  Progress progress;
  for (std::size_t i = 0; i < options.flights.size(); ++i) {
    const std::string& path = options.flights[i];
    sidecar_path(path);  // refuses what is no flight log
    const std::size_t replayed = before.size();
    std::optional<DataError> nothing;  // to replay in a part
    for (const std::vector<TimeRange>& part : diagnosis::parts_of(path)) {
      const FlightLog log = read_flight_log(path, part);
      for (const LogRepair& repair : log.repairs)
        if (warned.insert(repair.says).second) spdlog::warn(repair.says);
      if (!named && log.meta.vehicle.empty())
        throw DataError(fmt::format(
            "{}: \"vehicle\" is missing (whose flight is this?); name it here or with --vehicle", sidecar_path(path)));
      VehicleModel vehicle = named ? *named : read_vehicle(log.meta.vehicle, sidecar_path(path));
      if (vehicle.nominal_voltage_V == 0.0) vehicle.nominal_voltage_V = assumed_V;
      assume_nominal_voltage(vehicle, log);
      assumed_V = vehicle.nominal_voltage_V;
      try {
        wanted.with_noise = true;
        diagnosis::FitErrors errors = diagnosis::replay(log, vehicle, vehicle.effects, wanted);
        wanted.with_noise = false;
        if (with)
          after.push_back(diagnosis::replay(log, vehicle, config::merge_effects(vehicle.effects, *with), wanted));
        before.push_back(std::move(errors));
      } catch (const DataError& error) {
        nothing = error;
      }
    }
    if (before.size() == replayed) throw *nothing;
    if (nothing) spdlog::warn("a part is left out: {}", nothing->what());
    progress.show(i + 1, options.flights.size(), "flights");
  }
  progress.end();
  const nlohmann::ordered_json block = diagnosis::fit_block(before, after);
  if (options.format == "json") fmt::print("{}\n", block.dump(1));
  else print_text(block);
}

}  // namespace

void add_replay(CLI::App& app) {
  const auto options = std::make_shared<ReplayArguments>();
  CLI::App* command =
      app.add_subcommand("replay", "says how far the simulation is from recorded flights: open-loop rollouts");
  command->add_option("FLIGHT", options->flights, "flight logs, NAME.csv or NAME.csv.gz")->required();
  command->add_option("--vehicle", options->vehicle,
                      "name under models/ or path to a vehicle.toml or its folder (default: what the logs say)");
  command->add_option("--with", options->with, "TOML with [[effect]] tables: the model to compare, values are totals");
  command->add_option("--horizon", options->horizon_s, "seconds ahead, rising, separated by commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--stride", options->stride, "samples between window starts (default: windows do not overlap)")
      ->check(CLI::Range(1, 1000000));
  add_jobs(*command, options->jobs);
  command->add_option("--format", options->format)->check(CLI::IsMember({"text", "json"}))->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace gustlab
