// Whether a body turns, between the rows of a log, as rotors make it that are late. Where a loop is faster than its log, the command of a row
// falls until the next one: rotors that follow it then seem later than they are, and how they get from one measured speed to the next tells the two apart.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/model/catalogue.hpp"
#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// How much likelier (twice the logarithm) roll and pitch acceleration from row to row are with rotors as late as in `found` than with rotors as in
// `without`; between two measured speeds both follow the command of the row, and what is missing of it rises in a straight line. Nothing where speeds are
// not compared with commands, or the log says how these go on.
std::optional<double> latency_between_rows(const std::vector<FlightData>& flights, const Catalogue& catalogue,
                                           const Eigen::VectorXd& found, const Eigen::VectorXd& without);

}  // namespace gustlab::diagnosis
