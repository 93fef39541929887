// The published values for the Lorenz system: PySINDy's documentation, feature overview, three decimals.
#include <gtest/gtest.h>

#include "identification/differentiation.hpp"
#include "identification/optimizer.hpp"
#include "identification/synthetic.hpp"

namespace gustlab {
namespace lorenz_test {

// terms of polynomial:2:px,py,pz: 1, x, y, z, x², xy, xz, y², yz, z²
constexpr int x = 1, y = 2, z = 3, xy = 5, xz = 6, terms = 10;

RegressionData lorenz_data() {
  const Eigen::MatrixXd path = lorenz_path(5000);
  std::vector<FeatureInput> samples(5000);
  for (Eigen::Index i = 0; i < 5000; ++i) samples[static_cast<std::size_t>(i)].position_W_m = path.row(i);
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(5000, 0.0, 4999 * 0.002);
  const std::vector<FeatureTerm> library = make_library("polynomial:2:px,py,pz");
  return RegressionData(feature_matrix(library, samples), finite_difference(time_s, path));
}

void expect_only(const Eigen::MatrixXd& found, const std::vector<std::tuple<int, int, double>>& published) {
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3, terms);
  for (const auto& [target, term, value] : published) expected(target, term) = value;
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 0.0005 + 1e-9) << found;
  EXPECT_TRUE(((found.array() != 0.0) == (expected.array() != 0.0)).all()) << found;
}

TEST(Lorenz, StlsqGivesThePublishedCoefficients) {
  OptimizerOptions options;
  options.lambda = 0.1;
  options.refit = true;
  const Fit found = fit(find_optimizer("stlsq"), lorenz_data(), options);
  expect_only(
      found.coefficients,
      {{0, x, -9.999}, {0, y, 9.999}, {1, x, 27.992}, {1, y, -0.999}, {1, xz, -1.000}, {2, z, -2.666}, {2, xy, 1.000}});
}

TEST(Lorenz, ConstrainedSr3GivesThePublishedCoefficients) {
  OptimizerOptions options;
  options.lambda = 0.005;
  options.nu = 1.0;
  options.constraints.C = Eigen::MatrixXd::Zero(2, 3 * terms);
  options.constraints.C(0, x) = options.constraints.C(0, y) = 1.0;
  options.constraints.C(1, terms + x) = 1.0;
  options.constraints.d = Eigen::Vector2d(0.0, 28.0);
  const Fit found = fit(find_optimizer("sr3"), lorenz_data(), options);
  EXPECT_TRUE(found.converged);
  expect_only(found.coefficients, {{0, x, -10.002},
                                   {0, y, 10.002},
                                   {1, x, 28.000},
                                   {1, y, -1.003},
                                   {1, xz, -1.000},
                                   {2, z, -2.666},
                                   {2, xy, 0.999}});
  EXPECT_NEAR(found.full(0, x) + found.full(0, y), 0.0, 1e-10);
  EXPECT_NEAR(found.full(1, x), 28.0, 1e-10);
}

TEST(Lorenz, BestSubsetFindsTheSameSupport) {
  OptimizerOptions options;
  options.lambda = 1.0;
  const Fit found = fit(find_optimizer("best_subset"), lorenz_data(), options);
  expect_only(
      found.coefficients,
      {{0, x, -9.999}, {0, y, 9.999}, {1, x, 27.992}, {1, y, -0.999}, {1, xz, -1.000}, {2, z, -2.666}, {2, xy, 1.000}});
}

}  // namespace lorenz_test
}  // namespace gustlab
