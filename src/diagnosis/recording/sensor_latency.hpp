// How much later than the pose gyro and accelerometer are: their filters' delay, from what was recorded alone.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Of all flights alike. 0 when it is not observable, and when the pose is the later one: no sensor is early, so that is a late pose,
// which the dynamics must show.
SensorLatency sensor_latency(const std::vector<FlightData>& flights);

// Turns between attitudes a tenth of a second apart are compared with the integral of the gyro, which a delay d makes shorter by d
// times the change of the rate.
double rate_latency_s(const std::vector<FlightData>& flights);
// The same, where the attitudes are the later ones: by how much they may be, s (two standard errors beyond the likeliest); nothing without
// gyro or attitude.
std::optional<double> most_pose_latency_s(const std::vector<FlightData>& flights);
// Second differences of positions are compared with the double integral of the accelerometer, turned into W by the attitude.
// `rate_s`: of the gyro; the accelerometer is as late unless the positions surely say otherwise (one chip, filtered alike).
double force_latency_s(const std::vector<FlightData>& flights, double rate_s);

}  // namespace gustlab::diagnosis
