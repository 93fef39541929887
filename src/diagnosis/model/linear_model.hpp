// Linearises the simulator along a flight, see linear_flight.hpp.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/model/linear_flight.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Linearises one flight at given values. `wanted`: catalogue columns to differentiate (those of other flights are
// passed over), on so many threads. F is kept from a former call when there is one.
void linearise(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
               const std::vector<int>& wanted, LinearFlight& out, int jobs = 1);
// What the model predicts (b and y) at other values; F and what parameters change stay.
void predict_again(const FlightData& flight, int flight_index, const Catalogue& catalogue, const Eigen::VectorXd& value,
                   LinearFlight& out);

// What lower speed limits would change along a flight: of each, linear acceleration in W, angular in B, per sample.
std::vector<std::vector<SpatialAcceleration>> limit_changes(const FlightData& flight, int flight_index,
                                                            const Catalogue& catalogue, const Eigen::VectorXd& value,
                                                            const std::vector<double>& limits_radps);

}  // namespace gustlab::diagnosis
