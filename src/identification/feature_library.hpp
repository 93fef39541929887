// Which terms sparse regression chooses from: named libraries, and the matrix Θ that they give on samples.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/feature_terms.hpp"

namespace gustlab {

// A row of the registry of libraries.
struct LibraryRow {
  std::string_view name;
  std::string_view says;
};
std::span<const LibraryRow> library_registry();

// Reads a library:
//   paper                       the seven terms of Adaptive SINDy (arXiv 2603.08863, section II-A)
//   polynomial[:D[:a,b,…]]      all monomials up to degree D (default 2) of the variables (default vx,vy,vz), 1
//   included trigonometric[:K[:a,b,…]]   sin and cos of 1…K (default 1) times each variable (default phi,theta,psi)
//   a,b,…                       terms by name
// and sums of these with `+`; a term that comes twice is kept once. Throws ConfigError without a place.
std::vector<FeatureTerm> make_library(std::string_view text);

// Θ: one row per sample, one column per term.
Eigen::MatrixXd feature_matrix(std::span<const FeatureTerm> terms, std::span<const FeatureInput> samples);

}  // namespace gustlab
