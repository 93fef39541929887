// Where the recorded actuators predict angular acceleration no better than holding the body rate does: a model of how the vehicle turned under
// the controller that flew it. It is a habit of that loop and no physics (DIAGNOSIS.md §4), and is offered as that.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/estimation/session.hpp"
#include "diagnosis/result/diagnosis.hpp"

namespace gustlab::diagnosis {

// Coefficients of effect recorded_loop: rows are its eight terms, columns roll, pitch, yaw [rad/s² per term].
using Habit = Eigen::Matrix<double, 8, 3>;

// The habit that predicts body rates best over half a second, from every 0.4 s of the flights: least squares over whole rollouts
// (each flight in its own unit, large errors count less), velocity driven by the recorded specific force in body axes.
Habit fit_habit(const std::vector<FlightData>& flights, int jobs);

// Adds it to residual_toml of `out` and fills `habit` (its errors; the `fit` block stays that of physics) when on `holdout` what was
// found predicts body rates half a second ahead worse than holding them, and the habit predicts them, and all else, better than both.
void offer_habit(const Session& session, const std::vector<FlightLog>& holdout, int jobs, Diagnosis& out);

}  // namespace gustlab::diagnosis
