// The names of FORMATS.md §1.
#pragma once

#include <string_view>

namespace gustlab {

// Whether a column's name has a meaning in a flight log; u1…u8 and rotor1…rotor8 do.
bool is_known_column(std::string_view name);

}  // namespace gustlab
