// How much later than the attitude the gyro is: its filter's delay.
#pragma once

#include <vector>

#include "diagnosis/flight_data.hpp"

namespace gustlab::diagnosis {

// From attitudes and rates alone, one for all flights [s]: turns between attitudes a tenth of a second apart are compared with the
// integral of the gyro, which a delay d makes shorter by d times the change of the rate. 0 when it is not told, and when the attitude is
// the later one: no sensor is early, so that is a late pose, which the dynamics must tell.
double rate_lateness_s(const std::vector<FlightData>& flights);

}  // namespace gustlab::diagnosis
