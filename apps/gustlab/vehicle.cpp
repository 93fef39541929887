#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "options.hpp"
#include "python.hpp"
#include "simulation/vehicle_report.hpp"
#include "util/files.hpp"
#include "vehicle/new_vehicle.hpp"
#include "vehicle/read_vehicle.hpp"
#include "vehicle_fit.hpp"

namespace gustlab {

namespace {

struct NewArguments {
  std::string mass, arm, prop, layout, log, out = "my_vehicle";
  std::optional<double> thrust_to_weight, hover, throttle_curve;
};

constexpr std::pair<std::string_view, double> mass_units[] = {{"kg", 1.0}, {"g", 1e-3}, {"lb", 0.45359237}};
constexpr std::pair<std::string_view, double> length_units[] = {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"in", 0.0254}};

// "0.25m", "10 in": a number and one of these units, as SI
double quantity(const std::string& option, const std::string& text,
                std::span<const std::pair<std::string_view, double>> units) {
  std::size_t end = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &end);
  } catch (const std::logic_error&) {
    end = 0;
  }
  // 0x10 is a number for the library, and a slip of the keyboard here
  if (text.find_first_of("xX") < end) end = 0;
  std::string unit = text.substr(end);
  unit.erase(0, unit.find_first_not_of(' '));
  std::vector<std::string> known;
  for (const auto& [name, factor] : units) {
    known.emplace_back(name);
    if (end == 0 || unit != name) continue;
    if (!(value > 0.0) || !std::isfinite(value))
      throw ConfigError(fmt::format("{}: \"{}\" is not above zero", option, text));
    return value * factor;
  }
  throw ConfigError(fmt::format("{}: \"{}\" is not a number with a unit (units: {}); write for example {}", option,
                                text, fmt::join(known, ", "), units.front().first == "kg" ? "1.2kg" : "0.25m"));
}

// two digits that count; what is left of a millionth is rounding
std::string rounded(double value) {
  const std::string text = fmt::format("{:.2g}", std::abs(value) < 1e-6 ? 0.0 : value);
  return std::abs(value) < 99.5 ? text : fmt::format("{:.0f}", std::strtod(text.c_str(), nullptr));
}

// a name that is safe in a path, in TOML and in XML
std::string name_of(const std::filesystem::path& out) {
  std::string name = std::filesystem::absolute(out / ".").lexically_normal().parent_path().filename().string();
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') c = '_';
  return name.empty() ? "vehicle" : name;
}

std::optional<Sourced> sourced(const nlohmann::json& said, const char* key) {
  if (said[key].is_null()) return std::nullopt;
  return Sourced{said[key]["value"], said[key]["source"]};
}

// hubs of a log, which may be proportions only
void take_hubs(const nlohmann::json& said, const NewArguments& options, NewVehicle& wanted) {
  double mean_m = 0.0;
  for (const nlohmann::json& hub : said["hubs"]) {
    const std::vector<double> place = hub["position_B_m"];
    wanted.hubs.push_back({Vector3(place.data()), hub["counter_clockwise"]});
    mean_m += wanted.hubs.back().position_B_m.head<2>().norm() / static_cast<double>(said["hubs"].size());
  }
  wanted.hubs_source = said["hubs_source"];
  if (options.arm.empty()) {
    if (!said["metres"])
      throw ConfigError(fmt::format("--arm is missing: {} has the proportions of the airframe only", options.log));
    wanted.hubs_source += " (m)";
    return;
  }
  const double arm_m = quantity("--arm", options.arm, length_units);
  for (Hub& hub : wanted.hubs) hub.position_B_m *= arm_m / mean_m;
  wanted.hubs_source += fmt::format(", scaled to the mean arm of {:.4g} m that was given", arm_m);
}

// a hub in the same direction from the centre whose propeller turns the same way
bool has_hub(const Hub& wanted, const nlohmann::json& hubs) {
  const auto bearing = [](double x, double y) { return Vector3(x, y, 0.0).normalized(); };
  const Vector3 there = bearing(wanted.position_B_m.x(), wanted.position_B_m.y());
  const auto distance = [&](const nlohmann::json& hub) {
    const std::vector<double> place = hub["position_B_m"];
    return (bearing(place[0], place[1]) - there).norm();
  };
  const auto nearest = std::min_element(hubs.begin(), hubs.end(),
                                        [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  // as far as `gustlab import` lets them be apart
  return distance(*nearest) < 0.6 && (*nearest)["counter_clockwise"] == wanted.counter_clockwise;
}

// a layout that cannot be the log's is refused; places and turns in a log may be defaults
void compare_layout(const nlohmann::json& said, const NewArguments& options) {
  const Layout& layout = find_layout(options.layout);
  if (!said["rotors"].is_null() && said["rotors"]["value"] != layout.places.size())
    throw ConfigError(fmt::format(
        "--layout: \"{}\" has {} rotors, and {} flew in {} (its {}); leave --layout out, or give the layout that flew",
        layout.name, layout.places.size(), said["rotors"]["value"].get<int>(), options.log,
        said["rotors"]["source"].get<std::string>()));
  if (said["hubs"].is_null()) return;
  const std::vector<Hub> hubs = hubs_on_circle(layout, 1.0);
  if (!std::all_of(hubs.begin(), hubs.end(), [&](const Hub& hub) { return has_hub(hub, said["hubs"]); }))
    spdlog::warn(
        "--layout: the rotors of \"{}\" do not lie and turn as those of {} ({}); check which of them is right; "
        "--layout "
        "is written",
        layout.name, options.log, said["hubs_source"].get<std::string>());
}

// what the log says, where the user does not say otherwise
void take_log(const NewArguments& options, NewVehicle& wanted) {
  // a file may be called --help
  const std::string file = options.log.starts_with('-') ? "./" + options.log : options.log;
  const nlohmann::json said = nlohmann::json::parse(output_of_script("log_vehicle.py", {file}));
  if (!options.layout.empty()) compare_layout(said, options);
  else if (!said["hubs"].is_null()) take_hubs(said, options, wanted);
  if (!wanted.thrust_to_weight && !wanted.hover) wanted.hover = sourced(said, "hover");
  if (!wanted.throttle_curve) wanted.throttle_curve = sourced(said, "throttle_curve");
  wanted.torque_ratio_m = sourced(said, "torque_ratio_m");
}

NewVehicle wanted_vehicle(const NewArguments& options) {
  NewVehicle wanted;
  wanted.name = name_of(options.out);
  wanted.mass_kg = {quantity("--mass", options.mass, mass_units), "given"};
  if (!options.prop.empty())
    wanted.propeller_diameter_m = Sourced{quantity("--prop", options.prop, length_units), "given"};
  if (options.thrust_to_weight) wanted.thrust_to_weight = Sourced{*options.thrust_to_weight, "given"};
  if (options.hover) wanted.hover = Sourced{*options.hover, "given"};
  if (options.throttle_curve) wanted.throttle_curve = Sourced{*options.throttle_curve, "given"};
  if (!options.log.empty()) take_log(options, wanted);
  if (!wanted.hubs.empty()) return wanted;
  if (options.arm.empty())
    throw ConfigError("--arm is missing: the distance from the centre to a motor, with its unit, for example 0.25m");
  const double arm_m = quantity("--arm", options.arm, length_units);
  const Layout& layout = find_layout(options.layout.empty() ? "x" : options.layout);
  wanted.hubs = hubs_on_circle(layout, arm_m);
  wanted.hubs_source = fmt::format("layout {}, {}; arm of {:.4g} m given", layout.name, layout.source, arm_m);
  return wanted;
}

void make_new(const NewArguments& options) {
  const NewVehicle wanted = wanted_vehicle(options);
  const VehicleFiles files = new_vehicle_files(wanted);
  const std::filesystem::path folder(options.out), file = folder / "vehicle.toml",
                                                   body = folder / (wanted.name + ".xml");
  for (const auto& path : {file, body})
    if (std::filesystem::exists(path))
      throw ConfigError(
          fmt::format("{}: is there already (a vehicle is never overwritten); name another --out", path.string()));
  write_together([&] {
    make_folder(folder.string());
    write_file(body.string(), files.mjcf);
    write_file(file.string(), files.vehicle_toml);
  });
  for (const std::string& warning : files.warnings) spdlog::warn(warning);
  fmt::print("{}\n", file.string());
}

nlohmann::ordered_json to_json(const VehicleModel& vehicle, const VehicleReport& report) {
  const auto known = [](const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json trim = nlohmann::ordered_json::array();
  for (const RotorTrim& rotor : report.trim)
    trim.push_back({{"rotor", rotor.site},
                    {"speed_radps", rotor.speed_radps},
                    {"throttle", known(rotor.throttle)},
                    {"pwm", known(rotor.pwm)}});
  const Vector3& a = report.authority_radps2;
  return {{"format", "gustlab-vehicle-check/1"},
          {"vehicle", vehicle.name},
          {"mass_kg", report.mass_kg},
          {"weight_N", report.weight_N},
          {"arm_m", report.arm_m},
          {"thrust_to_weight", known(report.thrust_to_weight)},
          {"speed_scale_known", vehicle.rotor_speed_known},
          {"angular_acceleration_radps2", {a.x(), a.y(), a.z()}},
          {"motor_lag_s", {known(report.lag_up_s), known(report.lag_down_s)}},
          {"hover",
           {{"outcome", to_string(report.outcome)},
            {"flown_s", report.flown_s},
            {"error_m", report.error_m},
            {"tilt_rad", report.tilt_rad},
            {"trim", trim}}},
          {"unknown", report.unknown},
          {"contradictions", report.contradictions}};
}

void print_report(const VehicleModel& vehicle, const VehicleReport& report) {
  const auto say = [](std::string_view what, const std::string& value) { fmt::print("{:<22}{}\n", what, value); };
  const Vector3& a = report.authority_radps2;
  say("vehicle", fmt::format("{}, {} rotors", vehicle.name, vehicle.rotor_count));
  say("mass, weight", fmt::format("{:.4g} kg, {:.4g} N", report.mass_kg, report.weight_N));
  say("thrust to weight", report.thrust_to_weight
                              ? fmt::format("{:.3g}", *report.thrust_to_weight)
                              : "unknown: the file does not limit the rotors ([thrust] max_speed_radps)");
  say("turns in hover", fmt::format("roll {:.3g}, pitch {:.3g}, yaw {:.3g} rad/s^2 at most", a.x(), a.y(), a.z()));
  say("motor lag", !report.lag_up_s    ? "none in the file"
                   : report.lag_down_s ? fmt::format("{:.3g} s up, {:.3g} s down", *report.lag_up_s, *report.lag_down_s)
                                       : fmt::format("{:.3g} s", *report.lag_up_s));
  say("simulated hover", report.outcome == Outcome::completed
                             ? fmt::format("{} mm from the reference, tilted by {} deg", rounded(1e3 * report.error_m),
                                           rounded(report.tilt_rad * 180.0 / pi))
                             : std::string(to_string(report.outcome)));
  for (const RotorTrim& rotor : report.trim)
    say("  " + rotor.site,
        fmt::format("{:.4g} rad/s{}{}{}", rotor.speed_radps, vehicle.rotor_speed_known ? "" : " (scale estimated)",
                    rotor.throttle ? fmt::format(", throttle {:.3f}", *rotor.throttle) : "",
                    rotor.pwm ? fmt::format(", pwm {:.0f}", *rotor.pwm) : ""));
  for (const std::string& gap : report.unknown) say("left out", gap);
  for (const std::string& contradiction : report.contradictions) say("contradiction", contradiction);
  if (report.contradictions.empty()) say("contradictions", "none");
}

void check(const std::string& name, const std::string& format) {
  const VehicleModel vehicle = read_vehicle(name);
  const VehicleReport report = examine_vehicle(vehicle);
  if (format == "json") fmt::print("{}\n", config::json_text(to_json(vehicle, report), 1));
  else print_report(vehicle, report);
  if (!report.contradictions.empty()) throw ExitCode{1};
}

void add_new(CLI::App& group) {
  const auto options = std::make_shared<NewArguments>();
  CLI::App* command = group.add_subcommand(
      "new", "writes vehicle.toml and its MJCF from a few numbers; every number says where it comes from");
  std::vector<std::string> names;
  for (const Layout& layout : layouts()) names.emplace_back(layout.name);
  command->add_option("--mass", options->mass, "of the whole vehicle, with its unit: 1.2kg, 650g")->required();
  command->add_option("--arm", options->arm,
                      "from the centre to a motor, with its unit: 0.25m, 110mm (not needed where --from-log tells it)");
  command->add_option(
      "--prop", options->prop,
      "diameter of a propeller, with its unit: 10in (default: estimated from the distance of the motors)");
  command
      ->add_option("--thrust-to-weight", options->thrust_to_weight,
                   "thrust of all rotors at full throttle over the weight")
      ->check(positive());
  command->add_option("--hover", options->hover, "throttle in hover, 0 to 1, in place of --thrust-to-weight")
      ->check(positive());
  command
      ->add_option("--throttle-curve", options->throttle_curve, "f of thrust ~ f u^2 + (1 - f) u (default: estimated)")
      ->check(number_up_to(1.0));
  command->add_option("--layout", options->layout,
                      fmt::format("{} (default: the log's, or x)", fmt::join(names, " | ")));
  command->add_option("--from-log,--from-px4", options->log,
                      "a log of PX4 or ArduPilot: places and directions of the rotors, hover throttle, throttle curve");
  command->add_option("--out", options->out, "folder of the vehicle; its name is the vehicle's")->capture_default_str();
  command->callback([options] { make_new(*options); });
}

void add_check(CLI::App& group) {
  const auto name = std::make_shared<std::string>(), format = std::make_shared<std::string>("text");
  CLI::App* command = group.add_subcommand(
      "check", "flies a hover in simulation and looks for contradictions; exit 1 when there are some");
  command->add_option("VEHICLE", *name, "name under models/ or path to a vehicle.toml or its folder")->required();
  command->add_option("--format", *format)->check(CLI::IsMember({"text", "json"}))->capture_default_str();
  command->callback([name, format] { check(*name, *format); });
}

}  // namespace

void add_vehicle(CLI::App& app) {
  CLI::App* group = app.add_subcommand("vehicle", "makes, checks and fits vehicle files");
  group->require_subcommand(1);
  add_new(*group);
  add_check(*group);
  add_vehicle_fit(*group);
}

}  // namespace gustlab
