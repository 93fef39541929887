// Physics that no name means: a sparse model is offered when it predicts flights that were not used, and it flies.
#include "diagnosis/output/residual_effect.hpp"

#include <gmock/gmock.h>

#include <map>

#include "config/toml.hpp"
#include "gustlab/random.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace residual_effect_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// 2000 rows of twelve columns, the second a near copy of the first, and z: weights of the columns, and noise of 1
Eigen::MatrixXd gram_of(const std::vector<std::pair<int, double>>& weights) {
  const RandomStream random(5, 1, "matching_pursuit");
  Eigen::MatrixXd rows(2000, 13);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    for (Eigen::Index j = 0; j < 16; j += 4) {
      const auto drawn = random.normal4(static_cast<std::uint64_t>(4 * i + j / 4));
      for (Eigen::Index n = 0; n < 4 && j + n < 13; ++n) rows(i, j + n) = drawn[static_cast<std::size_t>(n)];
    }
    rows(i, 1) = rows(i, 0) + 0.1 * rows(i, 1);
    for (const auto& [column, weight] : weights) rows(i, 12) += weight * rows(i, column);
  }
  return rows.transpose() * rows;
}

TEST(MatchingPursuit, FindsTheColumnsThatAreThereAndTheirWeights) {
  const SparseFit found = matching_pursuit(gram_of({{0, 3.0}, {6, -1.3}, {11, 1.2}}), 0, 2000.0);
  ASSERT_THAT(found.chosen, ElementsAre(0, 6, 11));
  const double error = 4.0 / std::sqrt(2000.0);  // four standard errors of a weight
  EXPECT_NEAR(found.coefficient[0], 3.0, error);
  EXPECT_NEAR(found.coefficient[1], -1.3, error);
  EXPECT_NEAR(found.coefficient[2], 1.2, error);
  EXPECT_NEAR(found.loss, 2000.0, 4.0 * std::sqrt(2.0 * 2000.0));
}

TEST(MatchingPursuit, ChoosesNothingOfNoiseNorOfWhatIsFittedAlready) {
  EXPECT_THAT(matching_pursuit(gram_of({}), 0, 2000.0).chosen, IsEmpty());
  EXPECT_THAT(matching_pursuit(gram_of({{0, 3.0}, {2, 1.0}}), 3, 2000.0).chosen, IsEmpty());
}

// its gain, a quarter of the rows, is less than a tenth of what the first gained
TEST(MatchingPursuit, LeavesOutWhatGainsLittleBesideTheOthers) {
  EXPECT_THAT(matching_pursuit(gram_of({{0, 3.0}, {11, 0.5}}), 0, 2000.0).chosen, ElementsAre(0));
  EXPECT_THAT(matching_pursuit(gram_of({{11, 0.5}}), 0, 2000.0).chosen, ElementsAre(11));
}

TEST(MatchingPursuit, StopsAtItsNumberOfTerms) {
  std::vector<std::pair<int, double>> all;
  for (int j = 2; j < 12; ++j) all.emplace_back(j, 1.0);
  EXPECT_THAT(matching_pursuit(gram_of(all), 0, 2000.0).chosen, SizeIs(6));
}

Diagnosis diagnose_trial(const std::string& concealed) {
  const TemporaryFolder folder;
  return diagnose(test::fly_trial(folder, {.fit = {"lemniscate", "multisine"},
                                           .holdout = {"circle"},
                                           .tables = R"(
[trajectory.circle]
start = "reference"
ramp_s = 2.0
period_s = 6.0
[trajectory.lemniscate]
period_s = 6.0
[trajectory.multisine]
yaw_amplitude_rad = 0.8
)",
                                           .concealed = concealed}));
}

TEST(ResidualEffectTrials, DescribesAForceAcrossTheMotionAndFliesIt) {
  const Diagnosis d = diagnose_trial(
      R"({type = "sindy_residual", frame = "body", terms = ["vx_B", "vy_B"], fx = [0, -0.02], fy = [0.02, 0], fz = [0, 0]})");
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  ASSERT_FALSE(d.residual_model.is_null()) << to_json(d).dump(1);
  std::map<std::string, double> coefficient;
  for (const auto& term : d.residual_model["terms"])
    coefficient[term["channel"].get<std::string>() + " " + term["term"].get<std::string>()] =
        term["coefficient"].get<double>();
  EXPECT_NEAR(coefficient["force_x vy_B"], -0.02, 0.003);
  EXPECT_NEAR(coefficient["force_y vx_B"], 0.02, 0.003);
  // the held-out flight is predicted better with it, and it is part of the augmented vehicle
  EXPECT_LT(d.fit["position_m"]["after"][1].get<double>(), 0.7 * d.fit["position_m"]["before"][1].get<double>());
  EXPECT_GT(d.residual_model["fit_without"]["position_m"][1].get<double>(),
            d.fit["position_m"]["after"][1].get<double>());
  EXPECT_THAT(d.residual_model["says"].get<std::string>(), ::testing::HasSubstr("that is left without it"));
  config::Table table = config::Table::parse(d.augmented_toml, "augmented.toml");
  const std::vector<EffectSpec> effects = config::read_effects(table);
  ASSERT_FALSE(effects.empty());
  EXPECT_EQ(effects.back().type, "sindy_residual");
}

TEST(ResidualEffectTrials, OffersNothingWhereNothingIsMissing) {
  const Diagnosis d = diagnose_trial("");
  EXPECT_TRUE(d.residual_model.is_null());
  EXPECT_FALSE(to_json(d).contains("residual_model"));
}

}  // namespace residual_effect_test
}  // namespace gustlab::diagnosis
