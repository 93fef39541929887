#include "identification/model_selection.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

namespace gustlab {
namespace {

// entry i: all folds but the i-th
std::vector<RegressionData> complements(std::span<const RegressionData> folds) {
  if (folds.size() < 2) throw std::invalid_argument("cross-validation needs at least 2 folds");
  std::vector<RegressionData> out;
  for (std::size_t i = 0; i < folds.size(); ++i) {
    std::vector<RegressionData> others;
    for (std::size_t j = 0; j < folds.size(); ++j) {
      if (j != i) others.push_back(folds[j]);
    }
    out.push_back(RegressionData::merge(others));
  }
  return out;
}

}  // namespace

double rms_error(const RegressionData& data, const Eigen::MatrixXd& coefficients) {
  return std::sqrt(data.squared_error(coefficients).sum() / static_cast<double>(data.samples() * data.targets()));
}

double cross_validated_rms(const OptimizerRow& optimizer, std::span<const RegressionData> folds,
                           const OptimizerOptions& options) {
  const std::vector<RegressionData> others = complements(folds);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < folds.size(); ++i) {
    sum += folds[i].squared_error(fit(optimizer, others[i], options).coefficients).sum();
    count += static_cast<double>(folds[i].samples() * folds[i].targets());
  }
  return std::sqrt(sum / count);
}

LambdaChoice choose_lambda(const OptimizerRow& optimizer, std::span<const RegressionData> folds,
                           OptimizerOptions options) {
  const std::vector<RegressionData> others = complements(folds);
  const RegressionData all = RegressionData::merge(folds);
  const std::vector<double> lambdas = lambda_path(optimizer, all, options);
  const double n = static_cast<double>(folds.size());

  // error of each λ on each fold
  LambdaChoice out;
  Eigen::MatrixXd error(static_cast<Eigen::Index>(lambdas.size()), static_cast<Eigen::Index>(folds.size()));
  for (std::size_t i = 0; i < lambdas.size(); ++i) {
    options.lambda = lambdas[i];
    for (std::size_t k = 0; k < folds.size(); ++k) {
      error(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          folds[k].squared_error(fit(optimizer, others[k], options).coefficients).sum() /
          static_cast<double>(folds[k].samples());
    }
    const int active = static_cast<int>((fit(optimizer, all, options).coefficients.array() != 0.0).count());
    out.path.push_back({lambdas[i], error.row(static_cast<Eigen::Index>(i)).mean(), 0.0, 0.0, active});
    if (out.path[i].mean_squared_error < out.path[out.best].mean_squared_error) out.best = i;
  }

  const double negligible = negligible_share *
                            all.squared_error(Eigen::MatrixXd::Zero(all.targets(), all.terms())).sum() /
                            static_cast<double>(all.samples());

  // fold by fold against the best, so that what makes a fold hard for every λ cancels
  out.chosen = out.best;
  for (std::size_t i = 0; i < lambdas.size(); ++i) {
    const Eigen::ArrayXd excess =
        (error.row(static_cast<Eigen::Index>(i)) - error.row(static_cast<Eigen::Index>(out.best))).transpose().array();
    LambdaScore& score = out.path[i];
    score.excess = excess.mean();
    score.excess_std = std::sqrt((excess - score.excess).square().sum() / (n - 1.0) / n);
    // fewest coefficients; of equally many, the least error
    const LambdaScore& chosen = out.path[out.chosen];
    const bool simpler = std::tie(score.active, score.excess) < std::tie(chosen.active, chosen.excess);
    if (score.excess <= std::max(score.excess_std, negligible) && simpler) out.chosen = i;
  }
  return out;
}

}  // namespace gustlab
