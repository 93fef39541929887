// Are accelerometer and inputs what the recorded motion needs? A vehicle that turns at 3 g, or flies upside down, is judged by that.
#pragma once

#include <string>
#include <vector>

#include "gustlab/flight_log.hpp"
#include "gustlab/types.hpp"

namespace gustlab::diagnosis {

struct ForceFault {
  std::string column, kind, says;
  bool sets_column_aside = false;
};

// The accelerometer against the specific force Rᵀ(a + g e_z) of the recorded pose or, without one, against the commanded thrust per
// mass: is another unit, sign or frame far nearer, or none near? Then the thrust of the inputs, by the vehicle file, against mass
// times the specific force along the body's z axis: of the pose, else of the accelerometer, else of gravity alone (then only what no
// flight needs is a fault). Nothing where there is too little to judge by.
std::vector<ForceFault> check_forces(const FlightLog& log, const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
