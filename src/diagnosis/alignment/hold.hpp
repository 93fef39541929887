// Was the command held or interpolated between samples, when no log says so?
#pragma once

#include <functional>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// `read`: the flights with commands read in one way or the other.
bool linear_is_likelier(const VehicleModel& vehicle, int jobs,
                        const std::function<std::vector<FlightData>(bool linear)>& read);

// Whether measured rotor speeds jump to the commands of their rows, as rotors that obey at once do: on a row they are those before its command, and
// between rows they are larger than a straight line from one row to the next says. Judged by what either leaves of the change of the body's
// rates from row to row in roll and pitch, each axis with a gain of its own (the moment of inertia may be wrong). `read`: the flights in one way or
// the other; false where a flight has not both speeds and commands, in the same rows.
bool speeds_jump(const std::function<std::vector<FlightData>(bool jump)>& read);

// Whether rotors answer held commands as the vehicle file has it, now or late by whole rows: from the speed of a row and the command of a row the speed of the
// next one follows. False where a flight has not both speeds and commands, in the same rows, or where speeds hardly change.
bool speeds_follow(const std::vector<FlightData>& flights);

}  // namespace gustlab::diagnosis
