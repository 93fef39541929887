// `gustlab vehicle fit`: constants of a vehicle file from flights, by the diagnosis, or from a thrust stand.
#include <fmt/format.h>

#include <algorithm>
#include <boost/algorithm/string/replace.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "commands.hpp"
#include "config/toml.hpp"
#include "diagnose.hpp"
#include "diagnosis/diagnose.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/flight_log.hpp"
#include "options.hpp"
#include "plant/mjcf_files.hpp"
#include "progress.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"
#include "vehicle/edit_vehicle.hpp"
#include "vehicle/read_vehicle.hpp"
#include "vehicle/thrust_stand.hpp"
#include "vehicle_fit.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;

struct FitArguments {
  std::vector<std::string> logs, holdout;
  std::string vehicle, thrust_stand, out;
  int jobs = default_jobs();
};

// The files of a vehicle by path from its folder: vehicle.toml, the MJCF, and all that this names.
using Files = std::map<std::string, std::string>;
constexpr const char* vehicle_file = "vehicle.toml";
Files files_of(const VehicleModel& vehicle) {
  Files files = {{vehicle_file, read_file<ConfigError>(vehicle.source_path)}};
  const fs::path home = fs::path(vehicle.source_path).parent_path();
  const fs::path below = fs::relative(fs::path(vehicle.mjcf_path).parent_path(), home.empty() ? "." : home);
  for (auto& [name, bytes] : read_mjcf_files(vehicle.mjcf_path).bytes)
    files.emplace((below / name).lexically_normal().string(), std::move(bytes));
  return files;
}

// Where the fitted vehicle goes: nothing there is overwritten.
void check_new(const fs::path& folder, const Files& files) {
  for (const auto& [name, bytes] : files)
    if (fs::exists(folder / name))
      throw ConfigError(fmt::format("{}: is there already (a vehicle is never overwritten); name another --out",
                                    (folder / name).string()));
  check_folder_can_be_made(folder.string());
}

// Writes the vehicle, and then says what was fitted; nothing of both where it cannot be read again. `data`: what it was fitted to.
void write_vehicle(const fs::path& folder, const Files& files, const std::string& data, const std::string& said) {
  const auto write_into = [&](const fs::path& to) {
    for (const auto& [name, bytes] : files) {
      make_folder((to / name).parent_path().string());
      write_file((to / name).string(), bytes);
    }
  };
  const ScratchFolder trial(fs::temp_directory_path());
  write_into(trial.path());
  try {
    read_vehicle((trial.path() / vehicle_file).string());
  } catch (const ConfigError& error) {
    throw DataError(fmt::format("{}: the vehicle that it gives is refused: {}", data,
                                boost::replace_all_copy(std::string(error.what()), trial.path().string() + "/", "")));
  }
  write_together([&] { write_into(folder); });
  fmt::print("{}{}\n", said, (folder / vehicle_file).string());
}

// physics of the vehicle itself: not of one flight, of the room, of a sensor, and no damage
bool is_constant(const EffectRow& row) {
  return !row.per_flight && !row.external && !row.replay_only && row.diagnosable && row.place != Place::measurement &&
         !row.per_rotor && row.column != ColumnFrom::swing && !row.asks(Need::wall);
}

std::string with_spread(double value, double deviation) { return fmt::format("{:.4g} ± {:.2g}", value, deviation); }

// of several logs the last may be held out, and a log may be set aside
std::size_t flights_fitted(const diagnosis::Diagnosis& found) {
  std::set<std::string> files;
  for (const diagnosis::FlightUse& flight : found.flights)
    if (flight.role == "fit") files.insert(flight.file);
  return files.size();
}

std::string source_of(const diagnosis::EffectFinding& finding, std::size_t flights) {
  std::string text =
      fmt::format("fitted on {} {} by gustlab vehicle fit", flights, flights == 1 ? "flight" : "flights");
  if (finding.classmates.size() > 1) {
    std::vector<std::string> others(finding.classmates.begin() + 1, finding.classmates.end());
    text += fmt::format("; the flights cannot tell it from {}", fmt::join(others, ", "));
  }
  return text;
}

// one finding into the file: under its own key where the file has one for it, otherwise as an [[effect]]
void take(const diagnosis::EffectFinding& finding, const VehicleModel& vehicle, const std::string& source,
          std::string& text) {
  const auto& first = finding.parameters.front();
  const double factor = 1.0 + first.value;
  if (finding.effect == "yaw_torque_ratio") {
    const double ratio_m = vehicle.rotors[0].torque_ratio_m;
    set_key(text, "thrust", "torque_ratio", fmt::format("{:.5g}", ratio_m * factor),
            fmt::format("m, sd {:.2g}: {}", ratio_m * first.deviation, source));
    return;
  }
  const auto thrust = config::Table::parse(text, vehicle.source_path).table("thrust");
  if (finding.effect == "thrust_scale" && thrust && thrust->has("coefficient")) {
    const double coefficient = vehicle.rotors[0].thrust_coefficient_Ns2;
    set_key(text, "thrust", "coefficient", fmt::format("{:.5g}", coefficient * factor),
            fmt::format("N/(rad/s)^2, sd {:.2g}: {}", coefficient * first.deviation, source));
    return;
  }
  drop_effect(text, finding.effect);
  text += fmt::format("\n[[effect]]\ntype = \"{}\"\n# {}\n", finding.effect, source);
  for (const auto& value : finding.parameters)
    text += fmt::format("{} = {:.5g}  # {}, sd {:.2g}\n", value.name, value.value, value.unit, value.deviation);
}

// with_rest: the errors after are those of a model that holds more than the vehicle file gets
std::string error_lines(const nlohmann::ordered_json& fit, bool with_rest) {
  std::string said;
  if (!fit.is_object() || !fit.contains("position_m") || !fit["position_m"].contains("after")) return said;
  const auto& horizon = fit["horizon_s"];
  const auto &before = fit["position_m"]["before"], &after = fit["position_m"]["after"];
  for (std::size_t h = 0; h < horizon.size(); ++h)
    if (before[h].is_number() && after[h].is_number())
      said += fmt::format("position error {:.2g} s ahead on held-out flights: {:.3g} m before, {:.3g} m after{}\n",
                          horizon[h].get<double>(), before[h].get<double>(), after[h].get<double>(),
                          with_rest ? ", with what is not a constant of the vehicle" : "");
  return said;
}

// every finding into the file's text, and a line for each; `with_rest`: whether one of them is not written
std::string take_all(const diagnosis::Diagnosis& found, const VehicleModel& vehicle, std::string& text,
                     bool& with_rest) {
  std::string said;
  const std::size_t flights = flights_fitted(found);
  for (const auto* findings : {&found.effects, &found.calibration})
    for (const diagnosis::EffectFinding& finding : *findings) {
      const EffectRow* row = find_effect(finding.effect);
      if (row == nullptr || !is_constant(*row) || finding.parameters.empty()) {
        with_rest = true;
        said += fmt::format("{:<20} not written: it is of a flight, a sensor, the surroundings or one rotor\n",
                            diagnosis::with_rotor(finding.effect, finding.rotor()));
        continue;
      }
      // the time stamps of a log are no better than that
      if (findings == &found.calibration && row->latency == Latency::delay) {
        with_rest = true;
        const auto& delay = finding.parameters.front();
        said += fmt::format("{:<20} not written: {} {} is within its tolerance\n", finding.effect,
                            with_spread(delay.value, delay.deviation), delay.unit);
        continue;
      }
      take(finding, vehicle, source_of(finding, flights), text);
      for (const auto& value : finding.parameters)
        said += fmt::format("{:<20} {} = {}{}\n", finding.effect, value.name, with_spread(value.value, value.deviation),
                            value.unit == "-" ? "" : " " + value.unit);
    }
  return said;
}

void fit_flights(const FitArguments& options) {
  interrupted();
  diagnosis::DiagnoseOptions wanted;
  wanted.fit = options.logs;
  wanted.holdout = options.holdout;
  wanted.jobs = options.jobs;
  check_flights(wanted);
  const FlightLog first = read_flight_log(options.logs.front());
  const VehicleModel vehicle =
      options.vehicle.empty() ? read_vehicle(first.meta.vehicle, first.path) : read_vehicle(options.vehicle);
  Files files = files_of(vehicle);
  check_new(options.out, files);
  // without --vehicle all logs have to say the same one
  if (!options.vehicle.empty()) wanted.vehicle = vehicle.source_path;
  Progress progress;
  wanted.progress = progress.report();
  const diagnosis::Diagnosis found = diagnosis::diagnose(wanted);
  progress.end();
  warn_of_set_aside(found);
  bool with_rest = !found.residual_model.is_null();
  std::string said = take_all(found, vehicle, files[vehicle_file], with_rest);
  for (const diagnosis::NotIdentifiable& unknown : found.not_identifiable)
    if (const EffectRow* row = find_effect(unknown.effect); row != nullptr && is_constant(*row))
      said += fmt::format("{:<20} stays unknown: {}\n", unknown.effect, unknown.why);
  said += error_lines(found.fit, with_rest);
  write_vehicle(options.out, files, options.logs.front(), said);
}

// the input's map into the file: as it is where rotor speeds have a scale, otherwise as the input that hovers and how thrust rises
void take_map(const ThrustStand& stand, const VehicleModel& vehicle, const std::string& file, const std::string& source,
              std::string& text, std::string& said) {
  const auto& c = *stand.input_thrust;
  const std::string map = fmt::format("[{:.5g}, {:.5g}, {:.5g}]", c[0], c[1], c[2]), key = stand.input + "_thrust";
  const std::string says =
      fmt::format("N of one rotor, rms of the residual {:.2g} N: {}", stand.thrust_misfit_N, source);
  for (const std::string& old : {stand.input, key}) drop_key(text, "actuator", old);
  said += fmt::format("{:<20} {} (rms of the residual {:.2g} N)\n", key, map, stand.thrust_misfit_N);
  if (stand.coefficient_Ns2 || vehicle.rotor_speed_known) return set_key(text, "actuator", key, map, says);
  const double full = stand.full_input(), linear = c[1] * full, square = c[2] * full * full;
  const double wanted_N = vehicle.hover_thrust_N() - c[0];
  const double hover = square == 0.0 ? wanted_N / linear
                                     : (std::sqrt(linear * linear + 4.0 * square * wanted_N) - linear) / (2.0 * square);
  if (!(hover > 0.0 && hover < 1.0))
    throw DataError(fmt::format(
        "{}: a rotor of the vehicle carries {:.3g} N in hover, and thrust does not rise to that as {} rises "
        "(check --vehicle and the unit of thrust)",
        file, vehicle.hover_thrust_N(), stand.input));
  set_key(text, "thrust", "hover", fmt::format("{:.5g}", hover * full),
          fmt::format("{} that carries the weight: {}", stand.input, source));
  set_key(text, "actuator", "throttle_curve", fmt::format("{:.4g}", std::clamp(square / (linear + square), 0.0, 1.0)),
          source);
}

// the fastest that a rotor turns, of its thrust at full input
void take_max_speed(const ThrustStand& stand, const std::string& source, std::string& text, std::string& said) {
  const auto& c = *stand.input_thrust;
  const double full = stand.full_input(), thrust_N = c[0] + c[1] * full + c[2] * full * full;
  if (!(thrust_N > 0.0)) return;
  const double speed_radps = std::sqrt(thrust_N / stand.coefficient_Ns2->value);
  set_key(text, "thrust", "max_speed_radps", fmt::format("{:.5g}", speed_radps),
          fmt::format("rad/s, at {} {:g}: {}", stand.input, full, source));
  said += fmt::format("{:<20} {:.4g} rad/s\n", "max_speed_radps", speed_radps);
}

void fit_stand(const FitArguments& options) {
  const VehicleModel vehicle = read_vehicle(options.vehicle);
  Files files = files_of(vehicle);
  check_new(options.out, files);
  const ThrustStand stand = read_thrust_stand(options.thrust_stand);
  std::string &text = files[vehicle_file], said;
  const std::string source =
      fmt::format("thrust stand, {} rows of {}", stand.rows, fs::path(options.thrust_stand).filename().string());
  const auto set = [&](const char* key, const std::optional<Estimate>& estimate, const char* unit) {
    if (!estimate) return;
    set_key(text, "thrust", key, fmt::format("{:.5g}", estimate->value),
            fmt::format("{}, sd {:.2g}: {}", unit, estimate->deviation, source));
    said += fmt::format("{:<20} {} {}\n", key, with_spread(estimate->value, estimate->deviation), unit);
  };
  if (stand.coefficient_Ns2) {
    drop_key(text, "thrust", "hover");
    drop_key(text, "actuator", "throttle_curve");
    // `hover` told it, on a scale that is not that of the measured speeds
    if (!vehicle.rotor_speed_known) drop_key(text, "thrust", "max_speed_radps");
  }
  if (stand.input_thrust) take_map(stand, vehicle, options.thrust_stand, source, text, said);
  if (stand.coefficient_Ns2 && stand.input_thrust &&
      !(vehicle.rotor_speed_known && std::isfinite(vehicle.max_speed_radps)))
    take_max_speed(stand, source, text, said);
  set("coefficient", stand.coefficient_Ns2, "N/(rad/s)^2");
  set("torque_ratio", stand.torque_ratio_m, "m");
  if (stand.nominal_voltage_V)
    set_key(text, "thrust", "nominal_voltage_V", fmt::format("{:.4g}", *stand.nominal_voltage_V),
            "V, mean of the rows: " + source);
  if (stand.voltage_exponent) {
    drop_effect(text, "battery_sag");
    text += fmt::format("\n[[effect]]\ntype = \"battery_sag\"\n# {}\nexponent = {:.4g}  # sd {:.2g}\n", source,
                        stand.voltage_exponent->value, stand.voltage_exponent->deviation);
    said += fmt::format("{:<20} exponent = {}\n", "battery_sag",
                        with_spread(stand.voltage_exponent->value, stand.voltage_exponent->deviation));
  }
  for (const std::string& unknown : stand.unknown) said += fmt::format("stays unknown: {}\n", unknown);
  write_vehicle(options.out, files, options.thrust_stand, said);
}

void fit(const FitArguments& options) {
  if (options.logs.empty() == options.thrust_stand.empty())
    throw ConfigError(
        "vehicle fit takes flight logs or --thrust-stand FILE.csv, one of them (see gustlab vehicle fit --help)");
  if (options.thrust_stand.empty()) return fit_flights(options);
  if (options.vehicle.empty()) throw ConfigError("--vehicle is missing: whose rotor was on the thrust stand?");
  if (!options.holdout.empty()) throw ConfigError("--holdout: a thrust stand has no flights to hold out; leave it out");
  fit_stand(options);
}

}  // namespace

void add_vehicle_fit(CLI::App& group) {
  const auto options = std::make_shared<FitArguments>();
  CLI::App* command = group.add_subcommand(
      "fit", "estimates what a vehicle file does not know, from flights or a thrust stand, into a new vehicle file");
  command->add_option(
      "LOG", options->logs,
      "flight logs of one vehicle; thrust, torque ratio, inertia, lag, drag and battery as far as they tell them");
  command->add_option("--holdout", options->holdout, "flights to verify on (default: the last one)");
  command->add_option("--thrust-stand", options->thrust_stand,
                      "CSV of one rotor: thrust_N (or thrust_gf, thrust_kgf), speed_radps (or speed_rpm), torque_Nm, "
                      "voltage_V, throttle (or pulse_us, pwm)");
  command->add_option("--vehicle", options->vehicle,
                      "name under models/ or path to a vehicle.toml or its folder (default: what the logs say)");
  command->add_option("--out", options->out, "folder of the new vehicle")->required();
  add_jobs(*command, options->jobs);
  command->callback([options] { fit(*options); });
}

}  // namespace gustlab
