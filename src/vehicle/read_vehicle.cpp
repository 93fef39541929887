#include "vehicle/read_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"
#include "vehicle/mjcf.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;
using config::Table;

constexpr std::string_view format_name = "gustlab-vehicle/1";

// a path has a slash or ends with .toml; anything else is a name under models/
std::string vehicle_file(const std::string& name_or_path, const std::string& from_file) {
  if (name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".toml"))
    return (fs::path(from_file).parent_path() / name_or_path).lexically_normal().string();
  const std::vector<std::string> names = vehicle_names();
  if (std::find(names.begin(), names.end(), name_or_path) == names.end()) {
    const std::string near = config::suggest(name_or_path, names);
    throw ConfigError(fmt::format("{}unknown vehicle \"{}\" (known: {}){}{}", from_file.empty() ? "" : from_file + ": ",
                                  name_or_path, fmt::join(names, ", "), near.empty() ? "" : " ", near));
  }
  return find_resource("models/" + name_or_path + "/vehicle.toml");
}

double positive(Table& table, std::string_view key) {
  const double value = table.need_number(key);
  if (!(value > 0.0) || !std::isfinite(value)) table.fail(key, fmt::format("\"{}\" must be positive", key), "", "");
  return value;
}

double not_negative(Table& table, std::string_view key) {
  const double value = table.need_number(key);
  if (!(value >= 0.0) || !std::isfinite(value)) table.fail(key, fmt::format("\"{}\" must not be negative", key), "", "");
  return value;
}

// the MJCF lies in the vehicle's folder
std::string mjcf_file(Table& document) {
  const std::string file = document.need_text("mjcf");
  const fs::path folder = fs::path(document.path()).parent_path(), path = folder / file;
  const fs::path here = fs::current_path() / folder;
  const fs::path relative = fs::weakly_canonical(here / file).lexically_relative(fs::weakly_canonical(here));
  if (fs::path(file).is_absolute() || relative.empty() || *relative.begin() == "..")
    document.fail("mjcf", fmt::format("\"{}\" is outside the vehicle's folder", file), "a vehicle is one folder",
                  "move the file there");
  if (std::error_code error; !fs::is_regular_file(path, error))
    document.fail("mjcf", fmt::format("there is no file \"{}\"", path.string()), "", "");
  return path.string();
}

void read_thrust(Table& document, VehicleModel& vehicle, double& coefficient_Ns2, double& torque_ratio_m) {
  auto thrust = document.table("thrust");
  if (!thrust) document.fail({}, "[thrust] is missing", "it says what a rotor's speed does", "");
  coefficient_Ns2 = positive(*thrust, "coefficient");
  torque_ratio_m = not_negative(*thrust, "torque_ratio");
  vehicle.max_speed_radps = positive(*thrust, "max_speed_radps");
  vehicle.rotor_radius_m = positive(*thrust, "radius_m");
  if (thrust->has("nominal_voltage_V")) vehicle.nominal_voltage_V = positive(*thrust, "nominal_voltage_V");
}

void read_rotors(Table& document, const MjcfBody& body, VehicleModel& vehicle) {
  double coefficient_Ns2 = 0.0, torque_ratio_m = 0.0;
  read_thrust(document, vehicle, coefficient_Ns2, torque_ratio_m);
  std::vector<Table> tables = document.tables("rotor");
  if (tables.size() < 3 || tables.size() > static_cast<std::size_t>(max_rotors))
    document.fail("rotor", fmt::format("{} rotors", tables.size()), "a multirotor here has 3 to 8", "write one [[rotor]] for each");
  vehicle.rotor_count = static_cast<int>(tables.size());
  std::vector<std::string> names;
  for (const MjcfBody::Site& site : body.sites) names.push_back(site.name);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    Table& table = tables[i];
    Rotor& rotor = vehicle.rotors[i];
    rotor.site = table.need_text("site");
    const auto site = std::find(names.begin(), names.end(), rotor.site);
    if (site == names.end())
      table.fail("site", fmt::format("there is no site \"{}\" in {}", rotor.site, vehicle.mjcf_path),
                 fmt::format("sites on the vehicle: {}", names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))),
                 config::suggest(rotor.site, names));
    for (std::size_t j = 0; j < i; ++j)
      if (vehicle.rotors[j].site == rotor.site)
        table.fail("site", fmt::format("site \"{}\" carries two rotors", rotor.site), "", "give each rotor its own");
    const MjcfBody::Site& hub = body.sites[static_cast<std::size_t>(site - names.begin())];
    rotor.position_B_m = hub.position_B_m;
    rotor.axis_B = hub.axis_B;
    const std::string direction = table.need_text("direction");
    if (direction != "ccw" && direction != "cw")
      table.fail("direction", fmt::format("\"{}\" is not a direction", direction), "", "write \"ccw\" or \"cw\", seen from above");
    rotor.direction = direction == "ccw" ? 1.0 : -1.0;
    rotor.thrust_coefficient_Ns2 = table.has("coefficient") ? positive(table, "coefficient") : coefficient_Ns2;
    rotor.torque_ratio_m = torque_ratio_m;
  }
}

void read_actuator(Table& document, ActuatorMap& map) {
  auto actuator = document.table("actuator");
  if (!actuator) return;
  if (auto line = actuator->table("pwm")) map.pwm_line = {positive(*line, "slope"), line->need_number("offset")};
  if (const auto c = actuator->numbers("pwm_thrust")) {
    if (c->size() != 3)
      actuator->fail("pwm_thrust", "\"pwm_thrust\" must have three numbers", fmt::format("this has {}", c->size()),
                     "write [c0, c1, c2] of f = c0 + c1 pwm + c2 pwm^2");
    map.pwm_thrust = {(*c)[0], (*c)[1], (*c)[2]};
  }
  if (map.pwm_line && map.pwm_thrust)
    actuator->fail("pwm_thrust", "both \"pwm\" and \"pwm_thrust\" are here", "they are two answers to one question", "keep one");
}

}  // namespace

VehicleModel read_vehicle(const std::string& name_or_path, const std::string& from_file) {
  Table document = Table::read_file(vehicle_file(name_or_path, from_file));
  const std::string format = document.need_text("format");
  if (format != format_name)
    document.fail("format", fmt::format("format \"{}\" is not a vehicle's", format), "", fmt::format("write \"{}\"", format_name));

  VehicleModel vehicle;
  vehicle.source_path = document.path();
  vehicle.name = document.need_text("name");
  vehicle.mjcf_path = mjcf_file(document);
  const MjcfBody body = read_mjcf(vehicle.mjcf_path);
  vehicle.mass_kg = body.mass_kg;
  vehicle.center_of_mass_B_m = body.center_of_mass_B_m;
  vehicle.inertia_B_kgm2 = body.inertia_B_kgm2;
  vehicle.gravity_mps2 = body.gravity_mps2;
  vehicle.shapes = body.shapes;
  read_rotors(document, body, vehicle);
  read_actuator(document, vehicle.actuator);
  vehicle.effects = config::read_effects(document);
  document.finish();

  if (vehicle.hover_speed_radps() > vehicle.max_speed_radps)
    throw ConfigError(fmt::format("{}: the vehicle cannot hover (it takes {:.4g} rad/s, max_speed_radps is {:.4g}) "
                                  "check the units of coefficient and mass",
                                  vehicle.source_path, vehicle.hover_speed_radps(), vehicle.max_speed_radps));
  vehicle.source_bytes = read_file<ConfigError>(vehicle.source_path) + '\0' + body.bytes;
  return vehicle;
}

}  // namespace gustlab
