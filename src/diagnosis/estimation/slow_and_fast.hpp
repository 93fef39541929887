// Whether a candidate is of one size in slow and in fast changes. What the equations hold is; what resembles it over a part of the spectrum
// alone (a mass that swings, for a centre of mass) is not.
#pragma once

#include <Eigen/Core>

#include "diagnosis/estimation/signature.hpp"

namespace gustlab::diagnosis {

// How much its share of the fitted size differs between the two beyond two standard errors: the mean over all moving averages that divide
// slow from fast so that either holds a fifth of its information or more. 0 where none does (a constant has no fast changes).
// `fitted`: per parameter of the signature.
double slow_fast_difference(const SignatureSeries& parts, const Eigen::VectorXd& fitted);

}  // namespace gustlab::diagnosis
