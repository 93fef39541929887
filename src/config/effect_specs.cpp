// [[effect]] tables: reading them and laying one list over another.
#include <fmt/format.h>

#include <algorithm>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab::config {

namespace {

// what must be unique in a list: the type, and for a rotor's own effect the rotor
std::string identity(const EffectSpec& spec) {
  if (spec.type == "rotor_loss")
    for (const auto& [key, value] : spec.values)
      if (key == "rotor") return fmt::format("{} of rotor {}", spec.type, value);
  return spec.type;
}

EffectSpec* find(std::vector<EffectSpec>& specs, const EffectSpec& wanted) {
  const std::string name = identity(wanted);
  const auto found = std::find_if(specs.begin(), specs.end(), [&](const auto& spec) { return identity(spec) == name; });
  return found == specs.end() ? nullptr : &*found;
}

void check_unique(const std::vector<EffectSpec>& specs) {
  std::vector<EffectSpec> seen;
  for (const EffectSpec& spec : specs) {
    if (const EffectSpec* first = find(seen, spec))
      throw ConfigError(fmt::format("{}: effect \"{}\" is here twice (first at {}); keep one", spec.where,
                                    identity(spec), first->where));
    seen.push_back(spec);
  }
}

}  // namespace

void read_parameters(const EffectSpec& spec, Parameterized& target) {
  Table table = Table::of_effect(spec);
  read_parameters(table, target);
}

std::string where(const EffectSpec& spec, std::string_view parameter) {
  for (std::size_t i = 0; i < spec.value_where.size(); ++i)
    if (spec.values[i].first == parameter) return spec.value_where[i];
  return spec.where;
}

EffectSpec read_spec(Table& table, const std::string& type) {
  EffectSpec spec;
  spec.type = type;
  spec.where = table.where();
  for (const std::string& key : table.keys()) {
    if (key == "type") continue;
    spec.values.emplace_back(key, *table.literal(key));
    spec.value_where.push_back(table.where(key));
  }
  return spec;
}

std::vector<EffectSpec> read_effects(Table& document) {
  std::vector<EffectSpec> specs;
  for (Table& table : document.tables("effect")) specs.push_back(read_spec(table, table.need_text("type")));
  check_unique(specs);
  return specs;
}

std::vector<EffectSpec> merge_effects(const std::vector<EffectSpec>& base, const std::vector<EffectSpec>& over) {
  check_unique(base);
  check_unique(over);
  std::vector<EffectSpec> merged = base;
  for (const EffectSpec& spec : over) {
    if (EffectSpec* same = find(merged, spec)) *same = spec;
    else merged.push_back(spec);
  }
  return merged;
}

}  // namespace gustlab::config
