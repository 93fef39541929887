// Logs of inertial data alone whose torques are unknown: the specific force is what the rotors do now, with no motion
// between. Its residual is coloured, and a filter that whitens it sample by sample would weigh the highest frequencies
// most, where the rotors answer least; so it counts as white noise of the same strength at low frequencies.
#pragma once

#include "diagnosis/estimation/noise_model.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// As whiten(): rows are residuals of the specific force over the square root of the disturbance's long-run variance,
// 2 σ² τ / Δt for an Ornstein–Uhlenbeck process (σ, τ) sampled every Δt.
Whitened whiten_forces(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                       const FurtherColumns& further = {});

// As smooth(): the disturbance is the residual itself, in W.
Smoothed smooth_forces(const LinearFlight& flight);

}  // namespace gustlab::diagnosis
