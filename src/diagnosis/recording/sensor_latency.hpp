// How much later than the pose gyro and accelerometer are: their filters' delay, from what was recorded alone.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Of all flights alike. 0 when it is not observable, and when the pose is the later one: no sensor is early, so that is a late pose,
// which the dynamics must show. `further`: what the body turns more between a row and the next than the mean of the rates at both says, rad, per row of each
// flight, any share of which may be there; empty: nothing.
SensorLatency sensor_latency(const std::vector<FlightData>& flights,
                             const std::vector<std::vector<Vector3>>& further = {});

// Turns between attitudes a tenth of a second apart are compared with the integral of the gyro, which a delay d makes shorter by d
// times the change of the rate.
double rate_latency_s(const std::vector<FlightData>& flights, const std::vector<std::vector<Vector3>>& further = {});
// The same, where the attitudes are the later ones: by how much they may be, s (two standard errors beyond the likeliest); nothing without
// gyro or attitude.
std::optional<double> most_pose_latency_s(const std::vector<FlightData>& flights);
// Whether a simulator steps velocities first, and positions with the new ones (semi-implicit Euler): velocities are as much behind positions then as a gyro
// seems to be behind attitudes (`rate_s`), half a step, and it is the pose that is ahead of all else. Velocities that are recorded, and do not surely say
// otherwise: in a simulation a gyro alone may be filtered.
bool steps_velocities_first(const std::vector<FlightData>& as_recorded, double rate_s);
// Second differences of positions are compared with the double integral of the accelerometer, turned into W by the attitude.
// `rate_s`: of the gyro; the accelerometer is as late unless the positions surely say otherwise (one chip, filtered alike).
double force_latency_s(const std::vector<FlightData>& flights, double rate_s);

}  // namespace gustlab::diagnosis
