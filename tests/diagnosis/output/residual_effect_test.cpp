// Physics that no name means: a sparse model is offered when it predicts flights that were not used, and it flies.
#include <gmock/gmock.h>

#include <map>

#include "config/toml.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::IsEmpty;

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

}  // namespace
}  // namespace gustlab::diagnosis
