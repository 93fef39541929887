// A sparse model of the force that the known physics leaves over: f_W = Σ ξ_i φ_i(x, u), N in the world frame.
//
// `gustlab identify` writes it, the effect sindy_residual flies it, and Adaptive SINDy starts from its terms and
// coefficients (arXiv 2603.08863, section II). In TOML: terms = ["1", "T sin theta"], fx, fy, fz = one number per
// term, in N per unit of the term.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "control/feature_terms.hpp"
#include "gustlab/parameters.hpp"

namespace gustlab {

class ResidualModel {
 public:
  ResidualModel() = default;
  // coefficients: 3 × terms, N per unit of the term; terms that are zero on every axis are left out.
  ResidualModel(std::span<const FeatureTerm> terms, const Eigen::MatrixXd& coefficients);

  void visit(ParameterVisitor& visitor);
  // Reads the terms after parameters were set. Throws ParameterError when numbers and terms do not match.
  void prepare();

  std::span<const FeatureTerm> terms() const { return terms_; }
  const Eigen::Matrix<double, 3, Eigen::Dynamic>& coefficients() const { return coefficients_; }
  // Allocates nothing.
  Vector3 force_W_N(const FeatureInput& input) const;

 private:
  // as in the file
  std::vector<std::string> names_;
  std::vector<double> fx_, fy_, fz_;
  // as evaluated
  std::vector<FeatureTerm> terms_;
  Eigen::Matrix<double, 3, Eigen::Dynamic> coefficients_;
};

}  // namespace gustlab
