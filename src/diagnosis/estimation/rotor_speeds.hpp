// Where a log has both commands and measured rotor speeds, the speeds drive the body, and how the commands come to them (delay,
// saturation, sag, lag) is compared by itself: measured minus predicted speed, a row per rotor and sample.
#pragma once

#include "diagnosis/estimation/noise_model.hpp"
#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Measured speeds are noisy and miss what happened between samples, commands alone miss what nothing predicted: where commands predict
// most of the changes, both together are a better estimate of what drove the body.
void estimate_speeds(FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                     const SpeedNoise& noise);
// What commands do not predict of the speeds, rms, the map of every rotor in every flight apart.
double speeds_left_radps(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                         const Eigen::VectorXd& value);
// How much later than predicted the speeds change, to a quarter of a sample: commands that jitter show a delay only once it is nearly
// known. 0 where nothing is compared.
double speed_latency_s(const std::vector<FlightData>& data, const std::vector<LinearFlight>& flights);
// All of it white, as a first guess: a slow process would hide what changes slowly.
SpeedNoise white_speed_noise(const std::vector<FlightData>& data, const std::vector<LinearFlight>& flights);
// The likeliest noise of flights without columns, searched from a former one.
SpeedNoise likeliest(const std::vector<FlightData>& data, const std::vector<LinearFlight>& rest, SpeedNoise noise);

// Whitened rows as those of the body, y last. No map of an actuator is exact: of each rotor and flight, a constant and what goes with
// the predicted speed and its square are projected out. No rows where nothing is compared or the noise is not known.
Whitened whiten_speeds(const FlightData& data, const LinearFlight& flight, const SpeedNoise& noise);

}  // namespace gustlab::diagnosis
