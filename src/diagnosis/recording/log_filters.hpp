// Whether a log was low-pass filtered before it was written: its noise is then near zero from one sample to the next.
#pragma once

#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// Every column of position, attitude and body rate that is there. States of a simulation (`source` in the sidecar) are smooth without a filter.
bool motion_filtered(const FlightLog& log);
// Every column of commands and rotor speeds.
bool commands_filtered(const FlightLog& log);

}  // namespace gustlab::diagnosis
