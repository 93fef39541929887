// A loop that runs its rotors from one limit to the other.
#pragma once

#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Share of the logged commands in which some rotor is at the highest command of its flight, or that in which some is at the lowest: the
// smaller of the two. A signal that is not cut off is at its extremes once; commands that never change are left out.
double share_at_both_limits(const std::vector<FlightData>& flights);

}  // namespace gustlab::diagnosis
