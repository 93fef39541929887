// The Kalman filter that weighs what the simulator missed, and its smoother.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/estimation/noise_model.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// `further` are appended before y.
Whitened whiten(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                const FurtherColumns& further = {});

// Adds the same innovations to `blocks`, without ever having all of them.
void add_innovations(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise, GramBlocks& blocks,
                     const FurtherColumns& further = {});

// −2 log likelihood of a flight without columns whose poses or torques are known.
double misfit(const LinearFlight& flight, const NoiseModel& noise);

// What EM learns from, and the disturbance at every sample (6, in W and B), by a way back along the flight.
Smoothed smooth(const LinearFlight& flight, const NoiseModel& noise);

}  // namespace gustlab::diagnosis
