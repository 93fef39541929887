// What a vehicle file leaves out. Only effects that need it are not identifiable then.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gustlab/effect.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab {

struct VehicleGap {
  Need need;                   // effects that ask for it cannot be identified
  std::string_view what, key;  // in words, and how the vehicle file writes it
  std::string says() const;    // "the vehicle file has no rotor radius ([thrust] radius_m)"
};
std::vector<VehicleGap> gaps_of(const VehicleModel& vehicle);

// Where the file does not say at which voltage its maps hold: at the mean of this flight's.
void assume_nominal_voltage(VehicleModel& vehicle, const FlightLog& first);

}  // namespace gustlab
