// Sparse regression Y ≈ Θ Ξᵀ: which terms, and with which coefficients. One file per optimizer.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "identification/regression_data.hpp"

namespace gustlab {

enum class Regularizer { l0, l1, l2 };
Regularizer regularizer(std::string_view name);  // l0, l1, l2; throws ConfigError without a place

// Linear constraints C w = d on w = [ξ of target 0, ξ of target 1, …], in the units of the coefficients.
struct LinearConstraints {
  Eigen::MatrixXd C;  // constraints × (targets · terms)
  Eigen::VectorXd d;
  bool empty() const { return C.rows() == 0; }
};

struct OptimizerOptions {
  // stlsq: smallest |coefficient| that stays; sr3: weight λ of R; best_subset: ½ Σ(y − Θξ)² that a term must earn
  double lambda = 0.1;
  double ridge = 0.05;                    // stlsq: weight of ‖ξ‖²
  double nu = 1.0;                        // sr3: relaxation ν
  Regularizer penalty = Regularizer::l0;  // sr3: R
  LinearConstraints constraints{};        // sr3
  int max_terms = 0;                      // best_subset: most terms per target; 0: any number
  double tolerance = 1e-10;               // sr3: largest ‖Δu‖/ν at the end
  int max_iterations = 100000;            // stlsq, sr3
  bool normalize_columns =
      false;           // divide each column of Θ by its length first; λ then acts on the scaled coefficients
  bool refit = false;  // least squares on the support that was found, constraints kept
};

struct Fit {
  Eigen::MatrixXd coefficients;  // Ξ: targets × terms, zero where not active
  Eigen::MatrixXd full;          // sr3: the unthresholded w, on which C w = d holds exactly; otherwise as coefficients
  int iterations = 0;
  bool converged = true;
};

// A row of the registry of optimizers.
struct OptimizerRow {
  std::string_view name;
  std::string_view says;
  bool takes_constraints;
  bool takes_penalty;
  bool refits_by_default;                                      // as PySINDy does
  Fit (*run)(const RegressionData&, const OptimizerOptions&);  // Θ as given, no refit
  // λ from the sparsest that makes sense down to none
  std::vector<double> (*lambda_path)(const RegressionData&, const OptimizerOptions&);
};
std::span<const OptimizerRow> optimizer_registry();
const OptimizerRow& find_optimizer(std::string_view name);  // throws ConfigError without a place

// Scales, runs, refits, and scales back. Throws ConfigError when options make no sense together.
Fit fit(const OptimizerRow& optimizer, const RegressionData& data, const OptimizerOptions& options);

// The λ to try for `data`, columns scaled if the options say so.
std::vector<double> lambda_path(const OptimizerRow& optimizer, const RegressionData& data,
                                const OptimizerOptions& options);

using Support = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;  // targets × terms

// argmin Σ‖y − Θξ‖² with ξ zero off `support` (targets × terms) and C w = d. Throws ConfigError when C w = d has no
// solution on this support.
Eigen::MatrixXd constrained_least_squares(const RegressionData& data, const LinearConstraints& constraints,
                                          const Support& support);

// Sequentially thresholded (ridge) least squares (Brunton, Proctor, Kutz, PNAS 113, 2016).
Fit stlsq(const RegressionData& data, const OptimizerOptions& options);
// Sparse relaxed regularized regression, min ½‖Y − Θw‖² + λ R(u) + ‖w − u‖²/(2ν) with C w = d (Zheng et al., IEEE
// Access 7, 2019; Champion et al., IEEE Access 8, 2020).
Fit sr3(const RegressionData& data, const OptimizerOptions& options);
// The exact minimum of ½‖y − Θξ‖² + λ‖ξ‖₀ per target, by trying every support; at most 16 terms.
Fit best_subset(const RegressionData& data, const OptimizerOptions& options);

// n values from `largest` downwards, each a constant factor below the one before.
std::vector<double> geometric_path(double largest, double factor, int n);

}  // namespace gustlab
