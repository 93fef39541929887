// What a loop that is faster than the log does between its rows.
#pragma once

#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Share by which the body turns further between two rows than the mean of the rates at both says, as commands and rates predict it, and its standard
// error. Where a loop sets new commands on the rows, the torque α(s) that is logged there is more than its mean ᾱ until the next row, which the
// rates give. ∫ω ds − (ω₀ + ω₁) T/2 = ∫(T/2 − s) α(s) ds, and (α₀ − ᾱ) T²/6 where α falls in a straight line. Least squares through the
// origin, all axes and flights together, α₀ − ᾱ about its mean in each flight. 0 where no flight has commands of each rotor and body rates.
struct TurnBetweenRows {
  double share = 0.0, std = 0.0;
};
TurnBetweenRows turn_between_rows(const std::vector<FlightData>& flights);

}  // namespace gustlab::diagnosis
