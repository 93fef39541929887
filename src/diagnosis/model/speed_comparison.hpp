// Rotor speeds as the commands predict them against those that were measured.
#pragma once

#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/model/linear_flight.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Measured speeds at the samples, one row each [rad/s]; empty where they are not compared with commands: only one of the two was
// recorded, or torques are not judged. A session holds them in `FlightData::measured_at_sample`, from which the functions below read.
std::vector<RotorArray> measured_beside_commands(const FlightData& flight);
// Fills a flight's `predicted`, `faster` and `predicted_by`; nothing where speeds are not compared, or one record was written
// down as the other.
void compare_speeds(const FlightData& flight, int flight_index, const Catalogue& catalogue,
                    const Eigen::VectorXd& value, LinearFlight& out);
// The same at another value; `predicted_by` stays.
void compare_speeds_again(const FlightData& flight, int flight_index, const Catalogue& catalogue,
                          const Eigen::VectorXd& value, LinearFlight& out);

// What lower speed limits change of the speeds that commands predict: of each, one row per sample [rad/s].
std::vector<std::vector<RotorArray>> limit_speed_changes(const FlightData& flight, int flight_index,
                                                         const Catalogue& catalogue, const Eigen::VectorXd& value,
                                                         const std::vector<double>& limits_radps);

}  // namespace gustlab::diagnosis
