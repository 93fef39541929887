// The choice of λ by cross-validation over blocks of flight, and the error on data that a fit has not seen.
#pragma once

#include <span>
#include <vector>

#include "identification/optimizer.hpp"

namespace gustlab {

struct LambdaScore {
  double lambda = 0.0;
  double mean_squared_error = 0.0;  // per sample, summed over targets, mean over the folds
  double excess = 0.0;              // of that over the best λ
  double excess_std = 0.0;          // standard error of the excess over folds
  int active = 0;                   // coefficients ≠ 0 of the fit on all folds
};

// A λ is not worse than the best when its error exceeds the best one's by no more than one standard error, or by no
// more than this share of the target's mean square (a thousandth of its rms): on clean data the smallest error of a
// derivative would otherwise call for terms of its own.
inline constexpr double negligible_share = 1e-6;

struct LambdaChoice {
  std::vector<LambdaScore> path;  // from sparse to dense
  std::size_t best = 0;           // least error
  std::size_t chosen = 0;         // fewest coefficients that are not worse than the best (see negligible_share)
};

// Each fold is left out in turn; at least 2 folds. Folds should be whole flights or long blocks, because neighbouring
// samples are not independent.
LambdaChoice choose_lambda(const OptimizerRow& optimizer, std::span<const RegressionData> folds,
                           OptimizerOptions options);

// Root of the mean squared residual over samples and targets; units of the target.
double rms_error(const RegressionData& data, const Eigen::MatrixXd& coefficients);

// The same on each fold by the fit on all others, over all samples; at least 2 folds.
double cross_validated_rms(const OptimizerRow& optimizer, std::span<const RegressionData> folds,
                           const OptimizerOptions& options);

}  // namespace gustlab
