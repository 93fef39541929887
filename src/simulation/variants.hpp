// [[variant]] and [[axis]] of an experiment: what each of its variants is called, and what it changes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/toml.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

struct Variant {
  std::string name;
  std::vector<std::string> set;  // key=value
  std::vector<NamedValue> axes;  // where it stands on each axis
  bool held_out = false;
  std::string where;                    // file:line:col of what sets the most
  std::vector<NamedValue> axis_keys{};  // first key of each [[axis]] that is crossed
  NamedValue alone{};                   // the axis that it alone moves along; none of a grid
  std::size_t place = 0;                // among the variants of the file
};

// Every point of the grid that the axes span, the last axis fastest, for each [[variant]] (or once, where there is none); empty
// when there is neither. The points of an axis that is `alone` are variants of their own, after the others. Throws ConfigError with file:line:col.
std::vector<Variant> read_variant_tables(config::Table& document);

// The key that two settings (key=value) both set, a table and its own key included; "" when there is none.
std::string key_of_both(const std::string& setting, const std::string& other);
// The first two settings of a list that set one key, of which the value of the first would be lost.
struct SetTwice {
  std::string first, second, key;
};
std::optional<SetTwice> set_twice(const std::vector<std::string>& settings);

// names go into CSV cells and file names as they are
void check_name(const config::Table& table, std::string_view key, const std::string& name);

}  // namespace gustlab
