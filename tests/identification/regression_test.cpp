#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "gustlab/errors.hpp"
#include "identification/model_selection.hpp"
#include "identification/optimizer.hpp"
#include "identification/synthetic.hpp"

namespace gustlab {
namespace regression_test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Problem {
  MatrixXd theta, truth, target;
  RegressionData data() const { return RegressionData(theta, target); }
};

// the paper's library with three planted terms per axis or fewer
Problem planted(Index samples, double noise) {
  Problem p;
  p.theta = feature_matrix(make_library("paper"), rocking_flight(samples));
  p.truth = MatrixXd::Zero(3, 7);
  p.truth(0, 0) = 0.5;
  p.truth(0, 3) = -0.4;
  p.truth(1, 5) = 0.35;
  p.truth(2, 0) = -0.8;
  p.truth(2, 4) = 0.03;
  p.truth(2, 2) = 0.9;
  p.target = p.theta * p.truth.transpose();
  for (Index i = 0; i < samples; ++i) {
    for (Index t = 0; t < 3; ++t) p.target(i, t) += noise * spread(i, 11.0 + 2.0 * static_cast<double>(t));
  }
  return p;
}

TEST(RegressionData, KeepsWhatLeastSquaresNeeds) {
  const Problem p = planted(1000, 0.3);
  const RegressionData data = p.data();
  EXPECT_EQ(data.samples(), 1000);
  EXPECT_EQ(data.terms(), 7);
  EXPECT_EQ(data.targets(), 3);
  const MatrixXd direct = p.theta.colPivHouseholderQr().solve(p.target).transpose();
  EXPECT_LT((data.least_squares() - direct).norm(), 1e-9);
  EXPECT_LT((data.column_norms() - p.theta.colwise().norm().transpose()).norm(), 1e-9);
  const VectorXd values = Eigen::JacobiSVD<MatrixXd>(p.theta).singularValues();
  EXPECT_NEAR(data.condition_number() / (values[0] / values[6]), 1.0, 1e-9);
  for (const MatrixXd& coefficients : {MatrixXd(p.truth), MatrixXd(MatrixXd::Zero(3, 7)), direct}) {
    const VectorXd expected = (p.target - p.theta * coefficients.transpose()).colwise().squaredNorm();
    EXPECT_LT((data.squared_error(coefficients) - expected).norm(), 1e-9 * (1.0 + expected.norm()));
  }
}

TEST(RegressionData, MergedPartsAreTheWhole) {
  const Problem p = planted(1000, 0.3);
  std::vector<RegressionData> parts;
  for (Index first : {0, 3, 500}) {
    const Index rows = (first == 0 ? 3 : first == 3 ? 497 : 500);
    parts.emplace_back(p.theta.middleRows(first, rows), p.target.middleRows(first, rows));
  }
  const RegressionData merged = RegressionData::merge(parts);
  EXPECT_EQ(merged.samples(), 1000);
  EXPECT_LT((merged.least_squares() - p.data().least_squares()).norm(), 1e-9);
}

TEST(RegressionData, NonFiniteDataAreRefused) {
  Problem p = planted(100, 0.0);
  p.target(50, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(p.data(), DataError);
}

TEST(RegressionData, DependentColumnsGiveTheShortestSolution) {
  Problem p = planted(200, 0.0);
  p.theta.col(6) = 2.0 * p.theta.col(4);
  const MatrixXd expected = p.theta.completeOrthogonalDecomposition().solve(p.target).transpose();
  EXPECT_LT((p.data().least_squares() - expected).norm(), 1e-8);
  EXPECT_GT(p.data().condition_number(), 1e12);
}

TEST(Optimizers, FindPlantedTermsWithExactSupportOnNoiseFreeData) {
  const Problem p = planted(2000, 0.0);
  for (const OptimizerRow& row : optimizer_registry()) {
    OptimizerOptions options;
    options.lambda = row.name == "best_subset" ? 1e-9 : row.name == "sr3" ? 1e-5 : 0.01;
    options.ridge = 0.0;
    const Fit found = fit(row, p.data(), options);
    EXPECT_TRUE(found.converged) << row.name;
    EXPECT_TRUE(((found.coefficients.array() != 0.0) == (p.truth.array() != 0.0)).all()) << row.name << '\n'
                                                                                         << found.coefficients;
    EXPECT_LT((found.coefficients - p.truth).cwiseAbs().maxCoeff(), 1e-9) << row.name << '\n' << found.coefficients;
  }
}

TEST(Optimizers, CrossValidationFindsThePlantedTermsByItself) {
  for (double noise : {0.0, 0.1}) {
    const Problem p = planted(6000, noise);
    std::vector<RegressionData> folds;
    for (Index k = 0; k < 5; ++k)
      folds.emplace_back(p.theta.middleRows(1200 * k, 1200), p.target.middleRows(1200 * k, 1200));
    for (const OptimizerRow& row : optimizer_registry()) {
      OptimizerOptions options;
      options.normalize_columns = true;
      options.refit = true;
      options.ridge = 0.0;
      const LambdaChoice choice = choose_lambda(row, folds, options);
      options.lambda = choice.path[choice.chosen].lambda;
      const Fit found = fit(row, p.data(), options);
      EXPECT_TRUE(((found.coefficients.array() != 0.0) == (p.truth.array() != 0.0)).all())
          << row.name << " noise " << noise << " lambda " << options.lambda << '\n'
          << found.coefficients;
      EXPECT_LE(choice.path[choice.chosen].active, choice.path[choice.best].active);
    }
  }
}

TEST(Stlsq, EveryCoefficientIsAboveTheThresholdOrZero) {
  const Problem p = planted(500, 2.0);
  OptimizerOptions options;
  for (double threshold : {0.0, 0.01, 0.1, 0.5, 1.0, 100.0}) {
    options.lambda = threshold;
    const Fit found = fit(find_optimizer("stlsq"), p.data(), options);
    for (double value : found.coefficients.reshaped()) EXPECT_TRUE(value == 0.0 || std::abs(value) >= threshold);
  }
}

TEST(Sr3, AtItsFixedPointTheStationarityConditionsHold) {
  const Problem p = planted(500, 0.5);
  for (Regularizer penalty : {Regularizer::l0, Regularizer::l1, Regularizer::l2}) {
    OptimizerOptions options;
    options.penalty = penalty;
    options.lambda = 0.2;
    options.nu = 0.1;
    const Fit found = fit(find_optimizer("sr3"), p.data(), options);
    ASSERT_TRUE(found.converged);
    // gradient in w: Θᵀ(Θw − y) + (w − u)/ν = 0
    const MatrixXd w = found.full.transpose(), u = found.coefficients.transpose();
    const MatrixXd gradient = p.theta.transpose() * (p.theta * w - p.target) + (w - u) / options.nu;
    EXPECT_LT(gradient.norm(), 1e-6 * (p.theta.transpose() * p.target).norm());
    // u is the proximal step of w
    for (Index i = 0; i < w.size(); ++i) {
      const double a = w.reshaped()[i], b = u.reshaped()[i], k = options.lambda * options.nu;
      const double proximal = penalty == Regularizer::l0   ? (std::abs(a) > std::sqrt(2.0 * k) ? a : 0.0)
                              : penalty == Regularizer::l1 ? std::copysign(std::max(0.0, std::abs(a) - k), a)
                                                           : a / (1.0 + 2.0 * k);
      EXPECT_DOUBLE_EQ(b, proximal);
    }
  }
}

LinearConstraints two_constraints() {
  // ξ(0, T sin θ) + ξ(1, T sin φ) = 0 and ξ(2, 1) = −0.7
  LinearConstraints c;
  c.C = MatrixXd::Zero(2, 21);
  c.C(0, 3) = c.C(0, 7 + 5) = 1.0;
  c.C(1, 14) = 1.0;
  c.d = Eigen::Vector2d(0.0, -0.7);
  return c;
}

TEST(Sr3, ConstraintsHoldExactlyInW_AndAfterTheRefitInTheModel) {
  const Problem p = planted(500, 0.5);
  for (bool normalize : {false, true}) {
    OptimizerOptions options;
    options.constraints = two_constraints();
    options.lambda = 1e-3;
    options.normalize_columns = normalize;
    const Fit found = fit(find_optimizer("sr3"), p.data(), options);
    const MatrixXd w = found.full.transpose();
    EXPECT_LT((options.constraints.C * w.reshaped() - options.constraints.d).norm(), 1e-9);
    options.refit = true;
    const Fit refitted = fit(find_optimizer("sr3"), p.data(), options);
    const MatrixXd u = refitted.coefficients.transpose();
    EXPECT_LT((options.constraints.C * u.reshaped() - options.constraints.d).norm(), 1e-9);
  }
}

TEST(ConstrainedLeastSquares, IsTheBestOnItsSupportUnderItsConstraints) {
  const Problem p = planted(300, 1.0);
  const LinearConstraints constraints = two_constraints();
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> support = p.truth.array() != 0.0;
  support(1, 5) = true;
  const MatrixXd best = constrained_least_squares(p.data(), constraints, support);
  const double least = p.data().squared_error(best).sum();
  EXPECT_TRUE(((best.array() != 0.0) == support).all());
  // no small admissible step is better: along single free coefficients, and along the coupled pair
  for (double step : {-1e-3, 1e-3}) {
    MatrixXd moved = best;
    moved(0, 3) += step;
    moved(1, 5) -= step;
    EXPECT_GT(p.data().squared_error(moved).sum(), least);
    moved = best;
    moved(2, 4) += step;
    EXPECT_GT(p.data().squared_error(moved).sum(), least);
  }
}

TEST(ConstrainedLeastSquares, SaysWhenTheConstraintsCannotHold) {
  const Problem p = planted(300, 1.0);
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> support = p.truth.array() != 0.0;
  support(2, 0) = false;  // but ξ(2, 1) = −0.7 is asked for
  EXPECT_THROW(constrained_least_squares(p.data(), two_constraints(), support), ConfigError);
}

TEST(BestSubset, IsTheMinimumOverAllSupports) {
  const Problem p = planted(300, 3.0);
  const RegressionData data = p.data();
  OptimizerOptions options;
  options.lambda = 2.0;
  const Fit found = fit(find_optimizer("best_subset"), data, options);
  for (Index t = 0; t < 3; ++t) {
    const auto objective = [&](const MatrixXd& c) {
      return 0.5 * data.squared_error(c)[t] + 2.0 * static_cast<double>((c.row(t).array() != 0.0).count());
    };
    double least = std::numeric_limits<double>::infinity();
    for (unsigned mask = 0; mask < 128; ++mask) {
      MatrixXd c = MatrixXd::Zero(3, 7);
      std::vector<Index> support;
      for (Index j = 0; j < 7; ++j) {
        if (mask >> j & 1u) support.push_back(j);
      }
      const VectorXd solution = data.solve(support, t);
      for (std::size_t i = 0; i < support.size(); ++i) c(t, support[i]) = solution[static_cast<Index>(i)];
      least = std::min(least, objective(c));
    }
    EXPECT_NEAR(objective(found.coefficients), least, 1e-9 * least);
  }
}

TEST(BestSubset, ObeysTheLargestNumberOfTerms) {
  OptimizerOptions options;
  options.lambda = 0.0;
  for (int most : {1, 2, 3}) {
    options.max_terms = most;
    const Fit found = fit(find_optimizer("best_subset"), planted(300, 3.0).data(), options);
    for (Index t = 0; t < 3; ++t) EXPECT_EQ((found.coefficients.row(t).array() != 0.0).count(), most);
  }
}

TEST(NormalizeColumns, MakesTheResultIndependentOfUnits) {
  const Problem p = planted(500, 0.5);
  const VectorXd units = (VectorXd(7) << 1.0, 57.3, 57.3, 1e3, 1.0, 1e-3, 5.0).finished();
  for (const OptimizerRow& row : optimizer_registry()) {
    OptimizerOptions options;
    options.normalize_columns = true;
    options.lambda = 0.5;
    options.ridge = 0.0;
    const Fit one = fit(row, p.data(), options);
    const Fit other = fit(row, p.data().with_scaled_columns(units), options);
    EXPECT_LT((one.coefficients - other.coefficients * units.asDiagonal()).norm(),
              1e-8 * (1.0 + one.coefficients.norm()))
        << row.name;
  }
}

TEST(Options, NonsenseIsRefused) {
  const RegressionData data = planted(100, 0.1).data();
  const auto refuses = [&](const char* name, auto change) {
    OptimizerOptions options;
    change(options);
    EXPECT_THROW(fit(find_optimizer(name), data, options), ConfigError);
  };
  refuses("sr3", [](OptimizerOptions& o) { o.nu = 0.0; });
  refuses("sr3", [](OptimizerOptions& o) { o.lambda = -1.0; });
  refuses("sr3", [](OptimizerOptions& o) { o.tolerance = 0.0; });
  refuses("stlsq", [](OptimizerOptions& o) { o.max_iterations = 0; });
  refuses("stlsq", [](OptimizerOptions& o) { o.ridge = std::nan(""); });
  refuses("stlsq", [](OptimizerOptions& o) { o.constraints = two_constraints(); });
  refuses("sr3", [](OptimizerOptions& o) {
    o.constraints = two_constraints(), o.constraints.C.row(1) = 2.0 * o.constraints.C.row(0);
  });
  refuses("sr3", [](OptimizerOptions& o) { o.constraints = {MatrixXd::Zero(1, 20), VectorXd::Zero(1)}; });
  EXPECT_THROW(find_optimizer("lasso"), ConfigError);
  const MatrixXd wide = MatrixXd::Random(100, 17);
  EXPECT_THROW(fit(find_optimizer("best_subset"), RegressionData(wide, wide.leftCols(1)), {}), ConfigError);
}

TEST(ModelSelection, HeldOutErrorIsThatOfFoldsNotSeen) {
  const Problem p = planted(1000, 1.0);
  std::vector<RegressionData> folds;
  for (Index k = 0; k < 2; ++k) folds.emplace_back(p.theta.middleRows(500 * k, 500), p.target.middleRows(500 * k, 500));
  OptimizerOptions options;
  const OptimizerRow& row = find_optimizer("stlsq");
  const double first = rms_error(folds[0], fit(row, folds[1], options).coefficients);
  const double second = rms_error(folds[1], fit(row, folds[0], options).coefficients);
  EXPECT_NEAR(cross_validated_rms(row, folds, options), std::sqrt((first * first + second * second) / 2.0), 1e-12);
}

}  // namespace regression_test
}  // namespace gustlab
