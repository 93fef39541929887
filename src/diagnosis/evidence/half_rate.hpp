// What the sizes of effects become when every other row of the logs is left out. Physics stays as it is; what stands in for something that the
// log left out between its rows does not (as results of a simulation that depend on its grid: Roache, J. Fluids Eng. 116, 1994).
#pragma once

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Of rows with values in the same columns every other one: sensors with rates of their own, and inputs, stay all.
FlightLog every_other_row(FlightLog log);
// Relative change of each finding's size (of its values in natural units, along what they were). `half`: the same flights, with every other
// row alone; it is changed. Empty where these rows show other effects than all.
std::vector<double> changes_at_half_rate(Session& half, const Session& session, const Selection& selection);

}  // namespace gustlab::diagnosis
