// What nothing in the log predicted of the commands.
//
// A controller reads sensors that were not logged: faster, or with another noise. Its command then shows what the filter does not
// know yet (the disturbance of this very moment), and rotors that answer it seem weaker than they are: the bias of a direct
// identification in closed loop. Only the part that the log predicts is independent of what comes; the other part is given
// coefficients of its own (Ljung, System Identification, 1999, §13.4: instruments).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "plant/force_model.hpp"

namespace gustlab::diagnosis {

// Per sample, of the acceleration that the rotors cause until the next (roll, pitch, yaw [rad/s²], along the body's z [m/s²]): what a
// regression on all that was logged until then does not say, and what is remembered of that for as long as air lasts: it shows the
// vehicle's rates and the disturbance. Empty where torques are not known.
//
// Commands that were logged at a lower rate than the motion are regressed from command to command. Between two of them the loop
// went on and answered the motion: the mean of what it added is about a multiple of the body's rates, which has coefficients of its own.
std::vector<CommandInnovation> command_innovation(const FlightData& flight);

// Acceleration that the rotors cause at rest until the next sample, per sample: roll, pitch, yaw [rad/s²], along the body's z [m/s²]. Of the nominal
// vehicle, or by a model and a history of the rotors.
std::vector<Eigen::Vector4d> rotor_acceleration(const FlightData& flight);
std::vector<Eigen::Vector4d> rotor_acceleration(const FlightData& flight, const ForceModel& forces,
                                                const RotorHistory& rotors);

// Whether commands drive the rotors that were logged at a lower rate than the motion or of which it was found that the loop went on between them,
// and the log does not say that they were held.
bool commands_are_slower(const FlightData& flight);

}  // namespace gustlab::diagnosis
