#include "flight_log/columns.hpp"

#include <algorithm>

#include "gustlab/types.hpp"

namespace gustlab {

bool is_known_column(std::string_view name) {
  static constexpr std::string_view known[] = {
      "time_s", "px",  "py",  "pz",  "vx",  "vy",  "vz",  "qw",  "qx",  "qy",   "qz", "wx", "wy", "wz", "ax", "ay", "az",
      "vbat",   "rpx", "rpy", "rpz", "rvx", "rvy", "rvz", "rax", "ray", "raz", "ryaw", "fx", "fy", "fz", "tx", "ty", "tz"};
  if (std::find(std::begin(known), std::end(known), name) != std::end(known)) return true;
  for (const std::string_view prefix : {"u", "rotor"})
    if (name.size() == prefix.size() + 1 && name.starts_with(prefix))
      return name.back() >= '1' && name.back() < '1' + max_rotors;
  return false;
}

}  // namespace gustlab
