// A null that assumes no model of the rest: the same signature moved along its flight, or mirrored in time.
//
// What nothing explains keeps its own spectrum, its outliers and its dependence on everything else; only its coincidence with the
// signature goes. Residuals are those of the whole model (ter Braak 1992), so that a path that repeats itself does not find its own
// effect again one lap later. Theiler et al., Physica D 58, 1992; ter Braak, in: Bootstrapping and Related Techniques, 1992.
#pragma once

#include <Eigen/Core>

#include "diagnosis/estimation/signature.hpp"
#include "diagnosis/result/evidence.hpp"

namespace gustlab::diagnosis {

// `fitted`: per parameter of the signature
SurrogateTest surrogate_test(const SignatureSeries& parts, const Eigen::VectorXd& fitted);

}  // namespace gustlab::diagnosis
