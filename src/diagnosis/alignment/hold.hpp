// Was the command held or interpolated between samples, when no log says so?
#pragma once

#include <functional>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// `read`: the flights with commands read in one way or the other.
bool linear_is_likelier(const VehicleModel& vehicle, int jobs,
                        const std::function<std::vector<FlightData>(bool linear)>& read);

}  // namespace gustlab::diagnosis
