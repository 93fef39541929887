// The names of FORMATS.md §1.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gustlab {

// Whether a column's name has a meaning in a flight log; u1…u8 and rotor1…rotor8 do.
bool is_known_column(std::string_view name);
// The largest absolute value that a cell of a known column can hold and be a measurement, in the column's unit or in one that
// it is mistaken for (deg/s, mV, rpm): statistics of larger numbers overflow. std::nullopt for other columns.
std::optional<double> most_of_column(std::string_view name);
// Which of the names that are no known column may be meant by a missing one: `did you mean "…"?`, or empty.
std::string suggest_column(std::string_view missing, std::vector<std::string> names);

}  // namespace gustlab
