// Leaky recursive least squares with a tracking term: the law that Adaptive SINDy and DAIML adapt by.
//
//   A' = −λ A − P φᵀ (φ A − y)/R + P φᵀ s        P' = −2λ P + Q − P φᵀ φ P/R
//
// (arXiv 2603.08863, section II-B; Neural-Fly, O'Connell et al., Science Robotics 7(66) 2022, eq. 6–8.) φ is 1×n and shared by the
// three axes, A is n×3, P n×n, R a scalar. The paper prints the last term of P' without its trailing P, which is
// dimensionally wrong; that form is an option: P then shrinks along φ at a rate that does not depend on P itself, loses its
// symmetry, and the gain stays higher after long excitation.
//
// Discretised so that no step size can make it unstable: leak and growth first, then the measurement as a Kalman update
// with variance R/T in Joseph's form, which keeps P positive definite; the printed form is solved implicitly.
#pragma once

#include <Eigen/Core>

#include "gustlab/types.hpp"

namespace gustlab {

enum class CovarianceLaw { corrected, printed };

class Adaptation {
 public:
  static constexpr int max_terms = 24;
  using Row = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, max_terms>;
  using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, max_terms, 3>;
  using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_terms, max_terms>;

  struct Options {
    double leak_radps = 0.1;  // λ
    // units for features without one, y in m/s² and s in m/s, in which P φᵀ s and P φᵀ R⁻¹ (φ a − y) are both m/s³
    double noise = 1.0;             // R, 1/s
    double growth = 4.0;            // Q = growth · I, 1/s³
    double start_covariance = 1.0;  // P(0) = · I, 1/s²
    CovarianceLaw law = CovarianceLaw::corrected;
  };

  Adaptation() = default;
  // start: n×3, n at most max_terms
  Adaptation(const Options& options, const Parameters& start, double period_s);

  // One period with features φ (1×n), measured y, sliding error s; returns φ A after it.
  Vector3 update(const Row& phi, const Vector3& measured, const Vector3& sliding);
  Vector3 predict(const Row& phi) const { return (phi * parameters_).transpose(); }

  const Parameters& parameters() const { return parameters_; }
  const Covariance& covariance() const { return covariance_; }

 private:
  Options options_;
  double period_s_ = 0.01;
  Parameters parameters_;
  Covariance covariance_;
};

}  // namespace gustlab
