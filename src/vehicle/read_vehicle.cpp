#include "vehicle/read_vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"
#include "vehicle/mjcf.hpp"
#include "vehicle/read_thrust.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;
using config::Problems;
using config::Table;

constexpr std::string_view format_name = "gustlab-vehicle/1";

// a name under models/, a folder that holds a vehicle.toml, or else a path, which has a slash or ends with .toml
std::string vehicle_file(const std::string& name_or_path, const std::string& from_file) {
  const std::vector<std::string> names = vehicle_names();
  if (std::find(names.begin(), names.end(), name_or_path) != names.end())
    return find_resource("models/" + name_or_path + "/vehicle.toml");
  const fs::path path = (fs::path(from_file).parent_path() / name_or_path).lexically_normal();
  std::error_code error;
  if (!name_or_path.empty() && fs::is_regular_file(path / "vehicle.toml", error))
    return (path / "vehicle.toml").string();
  if (name_or_path.find('/') != std::string::npos || name_or_path.ends_with(".toml")) return path.string();
  if (name_or_path.ends_with(".xml") && fs::exists(name_or_path, error))
    throw ConfigError(name_or_path + ": an MJCF and no vehicle file; give the vehicle.toml that names it");
  throw ConfigError(
      worded(fmt::format("{}unknown vehicle \"{}\"", from_file.empty() ? "" : from_file + ": ", name_or_path),
             fmt::format("known: {}", fmt::join(names, ", ")), config::suggest(name_or_path, names)));
}

// the MJCF lies in the vehicle's folder
std::string mjcf_file(Table& document) {
  const std::string file = document.need_text("mjcf");
  const fs::path folder = fs::path(document.path()).parent_path(), path = folder / file;
  const fs::path here = fs::current_path() / folder;
  std::error_code error;
  const fs::path real = fs::weakly_canonical(here / file, error);
  // links in a circle, for one
  if (error) document.fail("mjcf", fmt::format("cannot read \"{}\" ({})", path.string(), error.message()), "", "");
  const fs::path relative = real.lexically_relative(fs::weakly_canonical(here));
  if (fs::path(file).is_absolute() || relative.empty() || *relative.begin() == "..")
    document.fail("mjcf", fmt::format("\"{}\" is outside the vehicle's folder", file), "a vehicle is one folder",
                  "move the file there");
  if (!fs::is_regular_file(path, error))
    document.fail("mjcf", fmt::format("there is no file \"{}\"", path.string()), "", "");
  return path.string();
}

// everything that is required and absent, with its unit and what it is for, in one message; empty when all is there
std::string missing_keys(Table& document) {
  std::vector<std::string> missing;
  const auto require = [&](bool there, const std::string& what) {
    if (!there) missing.push_back(what);
  };
  require(document.has("format"), fmt::format("format = \"{}\": what kind of file this is", format_name));
  require(document.has("mjcf"),
          "mjcf = \"FILE.xml\", beside this file: mass [kg], inertia [kg m^2] and a site at every rotor [m]");
  std::vector<Table> rotors = document.tables("rotor");
  require(!rotors.empty(),
          "[[rotor]], one for each of 3 to 8: site (its name in the MJCF) and direction (\"ccw\" or \"cw\" seen from "
          "above)");
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    require(rotors[i].has("site"), fmt::format("site of [[rotor]] {}: the name of its place in the MJCF", i + 1));
    require(
        rotors[i].has("direction"),
        fmt::format("direction of [[rotor]] {}: \"ccw\" or \"cw\" seen from above; without it nothing says how it yaws",
                    i + 1));
  }
  auto thrust = document.table("thrust");
  const bool every_own =
      std::all_of(rotors.begin(), rotors.end(), [](const Table& rotor) { return rotor.has("coefficient"); });
  require(thrust && (thrust->has("coefficient") || thrust->has("hover") || (every_own && !rotors.empty())),
          "under [thrust] coefficient [N/(rad/s)^2], or hover = the input (throttle 0..1, pwm or rad/s) that carries "
          "the weight: "
          "without one of them nothing says how much a rotor pushes");
  if (missing.empty()) return "";
  return fmt::format(
      "{}: {} missing:\n  {}\n(`gustlab defaults vehicle` prints a whole file, `gustlab vehicle new` writes one)",
      document.path(),
      missing.size() == 1 ? "one required key is" : fmt::format("{} required keys are", missing.size()),
      fmt::join(missing, "\n  "));
}

double read_direction(Table& rotor) {
  const std::string direction = rotor.need_text("direction");
  if (direction != "ccw" && direction != "cw")
    rotor.fail("direction", fmt::format("\"{}\" is not a direction", direction), "",
               "write \"ccw\" or \"cw\", seen from above");
  return direction == "ccw" ? 1.0 : -1.0;
}

// what is missing, of a wrong type or sign, or unknown: all of it in one message
void check_keys(Table& document) {
  Problems problems;
  problems.collect([&] { problems.add(missing_keys(document)); });
  for (const std::string_view key : {"format", "name", "mjcf"}) problems.collect([&] { document.text(key); });
  problems.collect([&] {
    for (Table& rotor : document.tables("rotor")) {
      problems.collect([&] { rotor.text("site"); });
      problems.collect([&] {
        if (rotor.has("direction")) read_direction(rotor);
      });
      problems.collect([&] { positive(rotor, "coefficient"); });
    }
  });
  check_thrust(document, problems);
  problems.collect([&] {
    for (Table& effect : document.tables("effect")) {
      config::read_spec(effect, "");  // whose keys are for the effect to judge
      problems.collect([&] { effect.need_text("type"); });
    }
  });
  for (const std::string& unknown : document.unknown_keys()) problems.add(unknown);
  problems.raise();
}

// places and directions; returns each rotor's own thrust coefficient where it says one
std::vector<std::optional<double>> read_rotors(Table& document, const MjcfBody& body, VehicleModel& vehicle) {
  std::vector<std::optional<double>> own_coefficient;
  std::vector<Table> tables = document.tables("rotor");
  if (tables.size() < 3 || tables.size() > static_cast<std::size_t>(max_rotors))
    document.fail("rotor", fmt::format("{} rotors", tables.size()), "a multirotor here has 3 to 8",
                  "write one [[rotor]] for each");
  vehicle.rotor_count = static_cast<int>(tables.size());
  std::vector<std::string> names;
  for (const MjcfBody::Site& site : body.sites) names.push_back(site.name);
  constexpr std::size_t most_said = 20;
  const std::span said(names.data(), std::min(names.size(), most_said));
  for (std::size_t i = 0; i < tables.size(); ++i) {
    Table& table = tables[i];
    Rotor& rotor = vehicle.rotors[i];
    rotor.site = table.need_text("site");
    const auto site = std::find(names.begin(), names.end(), rotor.site);
    if (site == names.end())
      table.fail(
          "site", fmt::format("there is no site \"{}\" in {}", rotor.site, vehicle.mjcf_path),
          fmt::format("sites on the vehicle: {}{}", names.empty() ? "none" : fmt::format("{}", fmt::join(said, ", ")),
                      names.size() > most_said ? fmt::format(" … ({} in all)", names.size()) : ""),
          config::suggest(rotor.site, names));
    for (std::size_t j = 0; j < i; ++j)
      if (vehicle.rotors[j].site == rotor.site)
        table.fail("site", fmt::format("site \"{}\" carries two rotors", rotor.site), "", "give each rotor its own");
    const MjcfBody::Site& hub = body.sites[static_cast<std::size_t>(site - names.begin())];
    rotor.position_B_m = hub.position_B_m;
    rotor.axis_B = hub.axis_B;
    rotor.direction = read_direction(table);
    own_coefficient.push_back(positive(table, "coefficient"));
  }
  return own_coefficient;
}

}  // namespace

VehicleModel read_vehicle(const std::string& name_or_path, const std::string& from_file) {
  Table document = Table::read_file(vehicle_file(name_or_path, from_file));
  // of another kind of file nothing else is said
  if (document.has("format"))
    if (const std::string format = document.need_text("format"); format != format_name)
      document.fail("format", fmt::format("format \"{}\" is not a vehicle's", format), "",
                    fmt::format("write \"{}\"", format_name));
  check_keys(document);

  VehicleModel vehicle;
  vehicle.source_path = document.path();
  const fs::path file = fs::absolute(document.path());
  vehicle.name = document.text("name").value_or(
      file.filename() == "vehicle.toml" ? file.parent_path().filename().string() : file.stem().string());
  vehicle.mjcf_path = mjcf_file(document);
  const MjcfBody body = read_mjcf(vehicle.mjcf_path);
  vehicle.mass_kg = body.mass_kg;
  vehicle.center_of_mass_B_m = body.center_of_mass_B_m;
  vehicle.inertia_B_kgm2 = body.inertia_B_kgm2;
  vehicle.gravity_mps2 = body.gravity_mps2;
  vehicle.shapes = body.shapes;
  read_thrust(document, read_rotors(document, body, vehicle), vehicle);
  vehicle.effects = config::read_effects(document);

  if (vehicle.hover_speed_radps() > vehicle.max_speed_radps)
    throw ConfigError(
        fmt::format("{}: the vehicle cannot hover (it takes {:.4g} rad/s, max_speed_radps is {:.4g}); "
                    "check the units of coefficient and mass",
                    vehicle.source_path, vehicle.hover_speed_radps(), vehicle.max_speed_radps));
  vehicle.source_bytes = read_file<ConfigError>(vehicle.source_path) + '\0' + body.bytes;
  return vehicle;
}

const VehicleModel& OneVehicle::of(const FlownBy& flight) {
  if (!vehicle_) {
    vehicle_ = read_vehicle(flight.vehicle, flight.flight);
    first_ = flight;
  }
  if (flight.vehicle.empty() || flight.flight == first_.flight) return *vehicle_;
  try {
    const VehicleModel its = read_vehicle(flight.vehicle, flight.flight);
    if (its.source_bytes != vehicle_->source_bytes)
      throw DataError(
          fmt::format("{} and {} are flights of two vehicles ({} and {}), and one model is for one vehicle; "
                      "give flights of one, or say with --vehicle which it is",
                      first_.flight, flight.flight, vehicle_->source_path, its.source_path));
  } catch (const ConfigError&) {
    if (flight.vehicle != first_.vehicle) throw;
  }
  return *vehicle_;
}

}  // namespace gustlab
