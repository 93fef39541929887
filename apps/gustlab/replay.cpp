#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "config/toml.hpp"
#include "diagnosis/recording/attitude_check.hpp"
#include "diagnosis/recording/log_checks.hpp"
#include "diagnosis/recording/stretches.hpp"
#include "diagnosis/result/finding_lines.hpp"
#include "diagnosis/rollout/replay.hpp"
#include "gustlab/effect.hpp"
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
  if (kind == "after_physics") return "without habit";
  return kind == "noise" ? "noise alone" : kind;
}

void print_text(const nlohmann::ordered_json& block) {
  fmt::print("{} windows; mean error at the horizon\n\n{:16} {:>9}", block["windows"].get<std::size_t>(), "",
             "horizon_s");
  std::vector<std::string> kinds;
  for (const auto& [kind, values] : block["position_m"].items()) {
    kinds.push_back(kind);
    fmt::print(" {:>13}", in_words(kind));
  }
  fmt::print("\n");
  for (const std::string_view name : diagnosis::fit_quantity_names) {
    const nlohmann::ordered_json& quantity = block[std::string(name)];
    for (std::size_t h = 0; h < block["horizon_s"].size(); ++h) {
      fmt::print("{:16} {:>9g}", h == 0 ? name : "", block["horizon_s"][h].get<double>());
      for (const std::string& kind : kinds) {
        const nlohmann::ordered_json& value = quantity[kind][h];
        fmt::print(" {:>13}", value.is_null() ? "-" : fmt::format("{:.4g}", value.get<double>()));
      }
      fmt::print("\n");
    }
  }
}

// what a diagnosis would say of units, frames and signs, and of numbers that cannot be. They are of the whole flight, so the minute in
// the middle tells them, and checks take no longer than the rollouts
std::vector<diagnosis::LogFinding> faults_of(const FlightLog& whole, const VehicleModel& vehicle) {
  const double middle_s = 0.5 * (whole.time_s.front() + whole.time_s.back());
  FlightLog log = diagnosis::part_of(whole, {middle_s - 30.0, middle_s + 30.0});
  if (log.rows() < 50) return {};
  std::vector<diagnosis::LogFinding> faults = diagnosis::check_attitude(log, vehicle);
  const auto more = diagnosis::check_log(log, vehicle);
  faults.insert(faults.end(), more.begin(), more.end());
  std::erase_if(faults, [](const diagnosis::LogFinding& f) {
    const bool contradicts = f.kind == "unit" || f.kind == "frame" || f.kind == "sign" || f.kind == "inconsistent",
               impossible = f.kind == "out_of_range" && f.sets_flight_aside;
    return !contradicts && !impossible;
  });
  return faults;
}

// the model to compare, as --with names it
std::vector<EffectSpec> read_model(const std::string& path) {
  config::Table document = config::Table::read_file(path);
  std::vector<EffectSpec> effects = config::read_effects(document);
  document.finish();
  // `effect = []` says that there is none, as a diagnosis that found nothing does
  if (!document.has("effect"))
    document.fail("", "there is no [[effect]]", "nothing to compare",
                  "name the augmented.toml of a diagnosis, or leave --with out");
  return effects;
}

class Replayer {
 public:
  explicit Replayer(const ReplayArguments& options) : options_(options) {
    wanted_.horizon_s = options.horizon_s;
    wanted_.stride = options.stride;
    wanted_.jobs = options.jobs;
    if (!options.with.empty()) models_.push_back(read_model(options.with));
    if (add_physics())
      spdlog::warn(
          "{}: holds the habit of the recorded loop (recorded_loop), which is no physics; \"without habit\" is "
          "without it",
          options.with);
    if (!options.vehicle.empty()) vehicle_ = read_vehicle(options.vehicle);
  }

  void add(const std::string& path) {
    sidecar_path(path);  // refuses what is no flight log
    const std::size_t replayed = errors_[0].size();
    std::optional<DataError> nothing;  // to replay in a part
    const std::vector<std::vector<TimeRange>> parts = diagnosis::parts_of(path);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const FlightLog log = read_flight_log(path, parts[i]);
      for (const LogRepair& repair : log.repairs)
        if (warned_.insert(repair.says).second) spdlog::warn(repair.says);
      take_vehicle(path, log);
      if (i == parts.size() / 2) {
        const auto found = faults_of(log, *vehicle_);
        faults_.insert(faults_.end(), found.begin(), found.end());
      }
      try {
        add(log);
      } catch (const DataError& error) {
        nothing = error;
      }
    }
    if (errors_[0].size() == replayed) throw *nothing;
    if (nothing) spdlog::warn("a part is left out: {}", nothing->what());
  }

  // the fit block of all flights; what is wrong with them is said
  nlohmann::ordered_json block() const {
    for (const auto& [kind, says] : diagnosis::finding_lines(faults_, options_.flights.size()))
      spdlog::warn("a diagnosis would say: {}: {}", kind, says);
    if (!faults_.empty()) spdlog::warn("here the flights are replayed as they are");
    return diagnosis::fit_block(errors_[0], errors_[1], errors_[2]);
  }

 private:
  // a model with a habit is compared without it, too; says whether it has one
  bool add_physics() {
    if (models_.empty()) return false;
    std::vector<EffectSpec> physics = models_.front();
    std::erase_if(physics, [](const EffectSpec& effect) {
      const EffectRow* row = find_effect(effect.type);
      return row != nullptr && row->replay_only;
    });
    if (physics.size() == models_.front().size()) return false;
    models_.push_back(std::move(physics));
    return true;
  }

  // the one that --vehicle names, or that all sidecars name
  void take_vehicle(const std::string& path, const FlightLog& log) {
    if (options_.vehicle.empty()) {
      if (log.meta.vehicle.empty())
        throw DataError(fmt::format(
            "{}: \"vehicle\" is missing (whose flight is this?); name it here or with --vehicle", sidecar_path(path)));
      const VehicleModel& vehicle = flown_.of({path, log.meta.vehicle});
      if (!vehicle_) vehicle_ = vehicle;
    }
    assume_nominal_voltage(*vehicle_, log);
  }

  void add(const FlightLog& log) {
    std::vector<diagnosis::FitErrors> errors;
    wanted_.with_noise = true;
    errors.push_back(diagnosis::replay(log, *vehicle_, vehicle_->effects, wanted_));
    wanted_.with_noise = false;
    for (const std::vector<EffectSpec>& model : models_)
      errors.push_back(diagnosis::replay(log, *vehicle_, config::merge_effects(vehicle_->effects, model), wanted_));
    for (std::size_t i = 0; i < errors.size(); ++i) errors_[i].push_back(std::move(errors[i]));
  }

  const ReplayArguments& options_;
  diagnosis::ReplayOptions wanted_;
  std::vector<std::vector<EffectSpec>> models_;  // that of --with, and where that has a habit the same without it
  std::optional<VehicleModel> vehicle_;
  OneVehicle flown_;
  std::array<std::vector<diagnosis::FitErrors>, 3> errors_;  // the vehicle as it is, then of each model
  std::vector<diagnosis::LogFinding> faults_;
  std::set<std::string> warned_;
};

void run(const ReplayArguments& options) {
  interrupted();
  check_horizons(options.horizon_s);
  check_paths_differ(options.flights, "a flight that is replayed twice counts twice");
  Replayer replayer(options);
  Progress progress;
  for (std::size_t i = 0; i < options.flights.size(); ++i) {
    replayer.add(options.flights[i]);
    progress.show(i + 1, options.flights.size(), "flights");
  }
  progress.end();
  const nlohmann::ordered_json block = replayer.block();
  if (options.format == "json") fmt::print("{}\n", config::json_text(block, 1));
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
