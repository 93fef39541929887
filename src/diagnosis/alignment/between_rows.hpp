// What a loop that is faster than the log does between its rows.
#pragma once

#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// What the body turns further between a row and the next than the mean of the rates at both says, by commands that are held, rad; zero where rates or commands of
// each rotor are missing.
// Where a loop sets new commands on the rows, the torque α(s) that is logged there is more than its mean ᾱ until the next row, which the rates give.
// ∫ω ds − (ω₀ + ω₁) T/2 = ∫(T/2 − s) α(s) ds, and (α₀ − ᾱ) T²/6 where α falls in a straight line; α₀ − ᾱ is about its mean.
std::vector<Vector3> further_turns(FlightData flight);

// The same as a share of what it turns, and its standard error: least squares through the origin, all axes and flights together. 0 where no flight has
// commands of each rotor and body rates.
struct TurnBetweenRows {
  double share = 0.0, std = 0.0;
};
TurnBetweenRows turn_between_rows(const std::vector<FlightData>& flights);

}  // namespace gustlab::diagnosis
