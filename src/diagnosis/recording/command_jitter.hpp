// Commands that were sampled from a faster loop: what jitters from sample to sample was never felt as it was logged.
#pragma once

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Share of the variance of the commanded roll and pitch torque (what is faster than half a hertz of it) that is white from
// sample to sample, the larger of the two axes: 0 smooth, 1 nothing but jitter. By third differences, robust.
// With more than that of a regressor being noise, effects come out smaller and lags longer by as much (attenuation;
// Fuller, Measurement Error Models, 1987).
double command_jitter_share(const FlightData& flight);
// The same of the total thrust, whose feedback through position and height is slower.
double thrust_jitter_share(const FlightData& flight);
// Where the torques of a log were not known from sample to sample: whether its thrust is not either, but for its mean.
bool only_mean_thrust_known(const FlightData& flight);

}  // namespace gustlab::diagnosis
