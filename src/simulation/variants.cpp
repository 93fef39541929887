#include "simulation/variants.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <utility>

#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

bool is_plain(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.'; }

// [[axis]]: keys that change together, point after point
struct Axis {
  struct Point {
    std::string value;             // what results call it
    std::vector<std::string> set;  // key=value
  };
  std::string name, key, where;  // key: the first
  bool alone = false;            // one point at a time, beside the variants
  std::vector<Point> points;
};

std::vector<std::string> read_keys(config::Table& table) {
  const auto key = table.text("key");
  const auto keys = table.texts("keys");
  if (key.has_value() == keys.has_value() || (keys && keys->empty()))
    table.fail("keys", "an axis needs \"key\" or \"keys\"", "", "write key = \"effect.gust.strength\", for example");
  return key ? std::vector<std::string>{*key} : *keys;
}

// one value for all keys, or one for each of them
std::vector<std::string> values_of_keys(config::Table& table, const std::string& literal, std::size_t keys) {
  if (keys == 1 || !literal.starts_with("[")) return std::vector<std::string>(keys, literal);
  const auto row = config::Table::parse("row = " + literal, "values").literals("row").value();
  if (row.size() != keys)
    table.fail("values", fmt::format("{} has {} values for {} keys", literal, row.size(), keys), "", "");
  return row;
}

// the first value, as a cell of a table
std::string label_of(std::string literal) {
  if (literal.starts_with("\"")) literal = literal.substr(1, literal.size() - 2);
  if (literal.ends_with(".0")) literal.resize(literal.size() - 2);
  std::replace_if(
      literal.begin(), literal.end(), [](char c) { return !is_plain(c); }, '-');
  return literal;
}

void check_once(const config::Table& table, std::string_view list, const std::vector<std::string>& settings) {
  if (const auto twice = set_twice(settings))
    table.fail(list, fmt::format("{} is set twice", twice->key), "its first value would be lost", "keep one");
}

Axis read_axis(config::Table& table) {
  const std::vector<std::string> keys = read_keys(table);
  Axis axis{table.text("name").value_or(keys.front().substr(keys.front().rfind('.') + 1)),
            keys.front(),
            table.where("values"),
            table.flag("alone").value_or(false),
            {}};
  check_name(table, "name", axis.name);
  const auto literals = table.literals("values");
  if (!literals || literals->empty())
    table.fail("values", "\"values\" is missing or empty", "an axis has points", "write values = [0.5, 1.0]");
  std::set<std::string> seen;
  for (const std::string& literal : *literals) {
    const std::vector<std::string> values = values_of_keys(table, literal, keys.size());
    Axis::Point& point = axis.points.emplace_back();
    point.value = label_of(values.front());
    if (!seen.insert(point.value).second)
      table.fail("values", fmt::format("\"{}\" is here twice", point.value), "results name a point by its first value",
                 "");
    for (std::size_t k = 0; k < keys.size(); ++k) point.set.push_back(fmt::format("{}={}", keys[k], values[k]));
  }
  check_once(table, "keys", axis.points.front().set);
  return axis;
}

// of two values for one key the first would be lost
void check_not_lost(const config::Table& table, const Variant& variant, const Axis& axis, const Axis::Point& point) {
  for (const std::string& setting : point.set)
    for (const std::string& other : variant.set)
      if (const std::string key = key_of_both(other, setting); !key.empty())
        table.fail(table.has("key") ? "key" : "keys", fmt::format("axis \"{}\" sets {} anew", axis.name, key),
                   fmt::format("the value of {} at {} would be lost", variant.name, variant.where),
                   "leave it out of one of them");
}

Variant at(const Variant& variant, const Axis& axis, const Axis::Point& point) {
  Variant result = variant;
  result.name += fmt::format("{}{}_{}", result.name.empty() ? "" : "_", axis.name, point.value);
  result.set.insert(result.set.end(), point.set.begin(), point.set.end());
  result.axes.push_back({axis.name, point.value});
  result.axis_keys.push_back({axis.name, axis.key});
  if (result.where.empty()) result.where = axis.where;
  return result;
}

}  // namespace

std::string key_of_both(const std::string& setting, const std::string& other) {
  try {
    for (const std::string& key : config::override_keys(setting))
      for (const std::string& own : config::override_keys(other))
        if (own == key || own.starts_with(key + ".") || key.starts_with(own + ".")) return own;
  } catch (const ConfigError&) {
    // what is no setting is refused where it is read
  }
  return "";
}

std::optional<SetTwice> set_twice(const std::vector<std::string>& settings) {
  for (std::size_t i = 0; i < settings.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (std::string key = key_of_both(settings[k], settings[i]); !key.empty())
        return SetTwice{settings[k], settings[i], std::move(key)};
  return std::nullopt;
}

void check_name(const config::Table& table, std::string_view key, const std::string& name) {
  if (name.empty() || !std::all_of(name.begin(), name.end(), is_plain))
    table.fail(key, fmt::format("\"{}\" is no name", name), "letters, digits, _, - and . make a name", "");
}

std::vector<Variant> read_variant_tables(config::Table& document) {
  std::vector<Variant> variants;
  std::set<std::string> seen;
  for (config::Table& table : document.tables("variant")) {
    variants.push_back({table.need_text("name"),
                        table.texts("set").value_or(std::vector<std::string>{}),
                        {},
                        table.flag("held_out").value_or(false),
                        table.where("set")});
    variants.back().axes.push_back({"variant", variants.back().name});
    check_name(table, "name", variants.back().name);
    check_once(table, "set", variants.back().set);
    if (!seen.insert(variants.back().name).second)
      table.fail("name", fmt::format("variant \"{}\" is here twice", variants.back().name), "", "rename one");
  }
  std::set<std::string> axes{"variant"};
  bool crossed = false;
  std::vector<Variant> alone;
  for (config::Table& table : document.tables("axis")) {
    const Axis axis = read_axis(table);
    if (!axes.insert(axis.name).second)
      table.fail("name", fmt::format("axis \"{}\" is here twice", axis.name), "", "give one of them a name of its own");
    if (axis.alone ? crossed : !alone.empty())
      table.fail("alone", "axes that are alone stand beside crossed ones",
                 "a point of either has no value on the other", "use one kind only");
    if (axis.alone) {
      for (const Axis::Point& point : axis.points) {
        Variant& variant = alone.emplace_back(at({}, axis, point));
        if (!seen.insert(variant.name).second)
          table.fail("values", fmt::format("variant \"{}\" is here twice", variant.name), "", "rename one");
        variant.alone = variant.axes.front();
        variant.axes = {{"variant", variant.name}};
        variant.axis_keys.clear();
      }
      continue;
    }
    crossed = true;
    if (variants.empty()) variants.emplace_back();
    std::vector<Variant> grid;
    for (const Variant& variant : variants)
      for (const Axis::Point& point : axis.points) {
        check_not_lost(table, variant, axis, point);
        grid.push_back(at(variant, axis, point));
      }
    variants = std::move(grid);
  }
  variants.insert(variants.end(), alone.begin(), alone.end());
  for (std::size_t place = 0; place < variants.size(); ++place) variants[place].place = place;
  return variants;
}

}  // namespace gustlab
