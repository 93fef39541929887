// A sparse model of what has no name: forces and torques as sums of a few terms of position or velocity, offered when it
// predicts flights that were not used (DIAGNOSIS.md §3.7).
#pragma once

#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// Sparse regression (orthogonal matching pursuit; Pati, Rezaiifar, Krishnaprasad, Asilomar 1993) on the whitened
// innovations of the fit flights, beside the effects of `out` (named and calibration). Variables that react to a
// disturbance (commands, tilt, rates) never enter: they would explain clean closed-loop flights. When open-loop rollouts on `holdout` become better, fills
// residual_model and residual_toml of `out`; the `fit` block is then that of the model with it. Linearises the session.
void offer_residual(Session& session, const Selection& selection, const std::vector<FlightLog>& holdout, int jobs,
                    Diagnosis& out);

}  // namespace gustlab::diagnosis
