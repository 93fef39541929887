// Does the vehicle accelerate the way its recorded attitude tilts?
#pragma once

#include <vector>

#include "diagnosis/result/findings.hpp"
#include "gustlab/flight_log.hpp"

namespace gustlab::diagnosis {

// In a hover too little turns for the body rate to show how a quaternion is written (flight_log/checks.hpp), but what
// tilts is pushed sideways: horizontal acceleration is the thrust per mass (in hover g) times the horizontal part of the body's z
// axis. Sets a flight
// aside when another reading of its quaternion explains the recorded motion and the one asked for does not. Says nothing
// without velocity, where nothing moves, or when no reading explains it: leaning against gusts shows nothing.
std::vector<LogFinding> check_attitude(const FlightLog& log, const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
