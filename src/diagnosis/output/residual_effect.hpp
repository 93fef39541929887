// A sparse model of what has no name: forces and torques as sums of a few terms of position or velocity, offered when it
// predicts flights that were not used (DIAGNOSIS.md §3.7).
#pragma once

#include "diagnosis/result/diagnosis.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

struct SparseFit {
  std::vector<int> chosen;  // of the columns offered, from 0, in the order of what they gain
  std::vector<double> coefficient;
  double loss = 0.0;  // what is left of zᵀz
};
// Orthogonal matching pursuit (Pati, Rezaiifar, Krishnaprasad, Asilomar 1993): the column that gains most, all refitted, until none
// gains enough (decisions::term_materiality). `gram`: of the columns that are always fitted (the first `beside`), those offered, and z;
// `rows`: the number of z's degrees of freedom.
SparseFit matching_pursuit(const Eigen::MatrixXd& gram, int beside, double rows);

// Sparse regression by matching pursuit on the whitened innovations of the fit flights, beside the effects of `out` (named and calibration). Variables that react to a
// disturbance (commands, tilt, rates) never enter: they would explain clean closed-loop flights. When open-loop rollouts on `holdout` become better, fills
// residual_model and residual_toml of `out`; the `fit` block is then that of the model with it. Linearises the session.
void offer_residual(Session& session, const Selection& selection, const std::vector<FlightLog>& holdout, int jobs,
                    Diagnosis& out);

}  // namespace gustlab::diagnosis
