// How a body turns from row to row, beside what its rotors do between these rows.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Whether body rates are known at both ends of a row.
inline bool has_rates(const Sample& now, const Sample& next) {
  return !next.starts_segment && (now.channels & next.channels & has_rate);
}

// Of the acceleration about one axis from row to row that rotors do not explain, whatever their gain.
struct AccelerationLeft {
  double share = 1.0;  // of its variance
  double rows = 0.0;   // as many as are independent, by the correlation of neighbours
};

// Roll and pitch. `rotors`: what they do until the next row, per row of each flight (`rotor_acceleration`). `kept`: how much of a row's acceleration is
// added to that of the next one; near one it is the body's rate and what rotors make of it, without what is slow.
std::array<AccelerationLeft, 2> acceleration_left(const std::vector<FlightData>& flights,
                                                  const std::vector<std::vector<Eigen::Vector4d>>& rotors, double kept);

}  // namespace gustlab::diagnosis
