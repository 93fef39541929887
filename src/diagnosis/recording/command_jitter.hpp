// Commands that were sampled from a faster loop: what jitters from sample to sample was never felt as it was logged.
#pragma once

#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Share of the variance of the commanded roll and pitch torque (what is faster than half a hertz of it, in all these flights together) that is
// white from sample to sample, the larger of the two axes: 0 smooth, 1 nothing but jitter. By third differences, robust. Where all flights have
// measured speeds of rotors that are not late by the vehicle file: the smaller one of the torques by commands and by speeds.
// With more than that of a regressor being noise, effects come out smaller and lags longer by as much (attenuation;
// Fuller, Measurement Error Models, 1987).
double command_jitter_share(std::vector<const FlightData*> flights);
// The same of the total thrust, whose feedback through position and height is slower.
double thrust_jitter_share(const std::vector<const FlightData*>& flights);
// Where the torques of logs were not known from sample to sample: whether their thrust is not either, but for its mean.
bool only_mean_thrust_known(const std::vector<FlightData>& flights);

}  // namespace gustlab::diagnosis
