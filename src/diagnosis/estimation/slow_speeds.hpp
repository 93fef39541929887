// Whether the slow changes of measured rotor speeds are as late as a lag or a delay says. Where commands of a faster loop were sampled,
// they jitter from row to row, and rows of the speeds follow a jitter that the log does not hold: a latency gains there because it
// averages the commands, however late the rotors are.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// How much likelier (twice the logarithm) the changes of means over a few rows are with the latency in `found` than with that in
// `without`, there up to one row later. Nothing where speeds are not compared with commands, or these predict the changes from row to row.
std::optional<double> latency_of_slow_speeds(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                                             const Eigen::VectorXd& found, const Eigen::VectorXd& without);

}  // namespace gustlab::diagnosis
