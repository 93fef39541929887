// Torque trims: a constant angular acceleration that every flight has for itself (a battery that was seated anew, warm rotors). They are
// small beforehand, and how small the flights say together (random effects; Laird & Ware, Biometrics 38, 1982). Without them a slow
// disturbance would have to be as large as they are, and would hide everything else that is slow.
#pragma once

#include <array>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/model/catalogue.hpp"

namespace gustlab::diagnosis {

using TrimVariance = std::array<double, 3>;  // of each axis, (rad/s²)²

// Adds to Gram matrices what is known beforehand: each trim of each flight is zero but for its variance, and numbers of effects are those of
// the vehicle file but for Column::known_to. `value`: where they are linearised.
void know_beforehand(const Catalogue& catalogue, const TrimVariance& variance, const Eigen::VectorXd& value,
                     Grams& grams);

// As large as a centre of mass that moves by some hundredth of an arm from flight to flight makes them.
TrimVariance usual_trims(const VehicleModel& vehicle);

// The likeliest variances about what all flights share (a centre of mass that nobody has named yet is no trim) and beside the effects of
// some columns, from Gram matrices that know_beforehand has not been told of: EM, from `variance`. `usual` counts as one flight more, since
// two that agree by chance say little. One flight alone says nothing of trims.
TrimVariance likeliest_trims(const Catalogue& catalogue, const std::vector<int>& columns, const Eigen::VectorXd& value,
                             const Grams& grams, const TrimVariance& usual, TrimVariance variance);

}  // namespace gustlab::diagnosis
