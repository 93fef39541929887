// Physics that no name means: a sparse model is offered when it predicts flights that were not used, and it flies.
#include <gmock/gmock.h>

#include <map>

#include "config/toml.hpp"
#include "diagnosis/diagnose.hpp"
#include "simulation/concealed_trials.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::IsEmpty;

// three flights of a Crazyflie in calm but not still air
Diagnosis diagnose_trial(const TemporaryFolder& folder, const std::string& concealed) {
  const TrialsFile file = read_trials_file(folder.write("trials.toml", R"(
format = "gustlab-trials/1"
name = "strange"
vehicle = "crazyflie"
trajectories = ["lemniscate", "multisine", "circle"]
controllers = ["geometric"]
fit = ["lemniscate", "multisine"]
holdout = ["circle"]
sensors = ["pose", "gyroscope"]
duration_s = 14.0
step_s = 0.002
[trajectory.circle]
start = "reference"
ramp_s = 2.0
period_s = 6.0
[trajectory.lemniscate]
period_s = 6.0
[trajectory.multisine]
yaw_amplitude_rad = 0.8
[[effect]]
type = "measurement_noise"
position_sd = 0.0005
attitude_sd = 0.002
rate_sd = 0.01
[[effect]]
type = "gust"
sigma_xy = 0.002
sigma_z = 0.002
correlation_time = 0.15
[[trial]]
name = "one"
effects = [)" + concealed + "]\n"));
  fly_concealed_trials(file, folder.file("flights"), 2);
  DiagnoseOptions options;
  options.fit = {folder.file("flights") + "/one/fit_1.csv", folder.file("flights") + "/one/fit_2.csv"};
  options.holdout = {folder.file("flights") + "/one/holdout_1.csv"};
  options.jobs = 2;
  return diagnose(options);
}

TEST(ResidualEffect, DescribesAForceAcrossTheMotionAndFliesIt) {
  const TemporaryFolder folder;
  const Diagnosis d = diagnose_trial(folder, R"({type = "sindy_residual", frame = "body", terms = ["vx_B", "vy_B"], fx = [0, -0.02], fy = [0.02, 0], fz = [0, 0]})");
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_EQ(d.verdict, Verdict::unexplained);
  ASSERT_FALSE(d.residual_model.is_null()) << to_json(d).dump(1);
  std::map<std::string, double> coefficient;
  for (const auto& term : d.residual_model["terms"])
    coefficient[term["channel"].get<std::string>() + " " + term["term"].get<std::string>()] = term["coefficient"].get<double>();
  EXPECT_NEAR(coefficient["force_x vy_B"], -0.02, 0.003);
  EXPECT_NEAR(coefficient["force_y vx_B"], 0.02, 0.003);
  // the held-out flight is predicted better with it, and it is part of the augmented vehicle
  EXPECT_LT(d.fit["position_m"]["after"][1].get<double>(), 0.7 * d.fit["position_m"]["before"][1].get<double>());
  config::Table table = config::Table::parse(d.augmented_toml, "augmented.toml");
  const std::vector<EffectSpec> effects = config::read_effects(table);
  ASSERT_FALSE(effects.empty());
  EXPECT_EQ(effects.back().type, "sindy_residual");
}

TEST(ResidualEffect, OffersNothingWhereNothingIsMissing) {
  const TemporaryFolder folder;
  const Diagnosis d = diagnose_trial(folder, "");
  EXPECT_TRUE(d.residual_model.is_null());
  EXPECT_FALSE(to_json(d).contains("residual_model"));
}

}  // namespace
}  // namespace gustlab::diagnosis
