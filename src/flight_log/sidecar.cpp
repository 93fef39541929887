#include "flight_log/sidecar.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "config/text.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

using config::Table;

constexpr std::string_view format_name = "gustlab-flight/1";

// the enumerator that a key names
template <class Enum>
Enum one_of(Table& table, std::string_view key, const std::string& text, std::initializer_list<Enum> values) {
  std::vector<std::string> names;
  for (const Enum value : values) {
    names.emplace_back(to_string(value));
    if (names.back() == text) return value;
  }
  table.fail(key, fmt::format("\"{}\" is not one of {}", text, fmt::join(names, ", ")), "",
             config::suggest(text, names));
}

std::vector<std::pair<std::string, std::string>> free_keys(Table& document, std::string_view key) {
  std::vector<std::pair<std::string, std::string>> result;
  if (auto table = document.table(key))
    for (const std::string& name : table->keys()) result.emplace_back(name, *table->literal(name));
  return result;
}

LogMeta read(const std::string& path) {
  Table document = Table::read_file(path);
  const std::string format = document.need_text("format");
  if (format != format_name)
    document.fail("format", fmt::format("format \"{}\" is not a flight log's", format), "",
                  fmt::format("write \"{}\"", format_name));
  LogMeta meta;
  meta.vehicle = document.text("vehicle").value_or("");
  meta.actuator = one_of(document, "actuator", document.need_text("actuator"),
                         {ActuatorKind::rotor_speed, ActuatorKind::thrust, ActuatorKind::throttle, ActuatorKind::pwm,
                          ActuatorKind::collective_thrust});
  meta.source = document.text("source").value_or("recording");
  if (meta.source != "recording" && meta.source != "simulation")
    document.fail("source", fmt::format("\"{}\" is not one of recording, simulation", meta.source), "", "");
  meta.hold =
      one_of(document, "hold", document.text("hold").value_or("unknown"), {Hold::unknown, Hold::zoh, Hold::linear});
  meta.notes = document.text("notes").value_or("");
  meta.environment = config::read_environment(document);
  meta.condition = free_keys(document, "condition");
  meta.origin = free_keys(document, "origin");
  document.finish();
  return meta;
}

void append_table(std::string& text, std::string_view name,
                  const std::vector<std::pair<std::string, std::string>>& values) {
  if (values.empty()) return;
  text += fmt::format("\n[{}]\n", name);
  for (const auto& [key, value] : values) {
    const bool bare = !key.empty() && key.find_first_not_of(
                                          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                          "0123456789_-") == std::string::npos;
    text += fmt::format("{} = {}\n", bare ? key : config::quoted(key), value);
  }
}

}  // namespace

std::string sidecar_path(const std::string& csv_path) {
  for (const std::string_view ending : {".csv", ".csv.gz"})
    if (csv_path.ends_with(ending)) return csv_path.substr(0, csv_path.size() - ending.size()) + ".meta.toml";
  const std::string inside = (std::filesystem::path(csv_path) / "flight.csv").string();
  std::error_code ignored;
  throw DataError(worded(csv_path + ": not a flight log", "its name must end with .csv or .csv.gz",
                         std::filesystem::exists(inside, ignored) ? fmt::format("did you mean \"{}\"?", inside) : ""));
}

LogMeta read_sidecar(const std::string& path) {
  // what is wrong with a recording's description is wrong with the data
  try {
    return read(path);
  } catch (const ConfigError& error) {
    throw DataError(error.what());
  }
}

std::string sidecar_text(const LogMeta& meta) {
  std::string text = fmt::format("format = \"{}\"\n", format_name);
  if (!meta.vehicle.empty()) text += fmt::format("vehicle = {}\n", config::quoted(meta.vehicle));
  text += fmt::format("actuator = \"{}\"\nsource = \"{}\"\nhold = \"{}\"\nnotes = {}\n", to_string(meta.actuator),
                      meta.source, to_string(meta.hold), config::quoted(meta.notes));
  std::vector<std::pair<std::string, std::string>> environment;
  if (meta.environment.ground_z_m)
    environment.emplace_back("ground_z_m", config::shortest(*meta.environment.ground_z_m));
  if (meta.environment.ceiling_z_m)
    environment.emplace_back("ceiling_z_m", config::shortest(*meta.environment.ceiling_z_m));
  std::string walls;
  for (const auto& [point, normal] : meta.environment.walls)
    walls += fmt::format("{}[{}, {}, {}, {}]", walls.empty() ? "" : ", ", config::shortest(point.x()),
                         config::shortest(point.y()), config::shortest(normal.x()), config::shortest(normal.y()));
  if (!walls.empty()) environment.emplace_back("walls", "[" + walls + "]");
  append_table(text, "environment", environment);
  append_table(text, "condition", meta.condition);
  append_table(text, "origin", meta.origin);
  return text;
}

}  // namespace gustlab
