#include "flight_log/columns.hpp"

#include <algorithm>

#include "config/toml.hpp"
#include "gustlab/types.hpp"

namespace gustlab {

namespace {

struct Columns {
  double most;
  std::initializer_list<std::string_view> names;
};
constexpr double most_of_rotors = 2e5;
const Columns known_columns[] = {
    {1e11, {"time_s"}},
    {1e7, {"px", "py", "pz", "rpx", "rpy", "rpz"}},
    {1e5, {"vx", "vy", "vz", "rvx", "rvy", "rvz", "ax", "ay", "az", "rax", "ray", "raz", "wx", "wy", "wz", "ryaw"}},
    {1e5, {"fx", "fy", "fz", "tx", "ty", "tz", "vbat", "qw", "qx", "qy", "qz"}}};

}  // namespace

std::optional<double> most_of_column(std::string_view name) {
  for (const Columns& columns : known_columns)
    if (std::find(columns.names.begin(), columns.names.end(), name) != columns.names.end()) return columns.most;
  for (const std::string_view prefix : {"u", "rotor"})
    if (name.size() == prefix.size() + 1 && name.starts_with(prefix) && name.back() >= '1' &&
        name.back() < '1' + max_rotors)
      return most_of_rotors;
  return std::nullopt;
}

bool is_known_column(std::string_view name) { return most_of_column(name).has_value(); }

std::string suggest_column(std::string_view missing, std::vector<std::string> names) {
  std::erase_if(names, is_known_column);
  return config::suggest(missing, names);
}

}  // namespace gustlab
