// What looks like physics and is not: forces that are uneven, many small trims, and a gust's parts.
#include <gmock/gmock.h>

#include "diagnosis/validation/gust_parts.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace challenge_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Diagnosis diagnose_concealed(const std::string& concealed) {
  const TemporaryFolder folder;
  test::TrialSettings trial;
  trial.fit = {"lemniscate", "multisine"};
  trial.holdout = {"circle"};
  trial.concealed = concealed;
  return diagnose(test::fly_trial(folder, trial));
}

const NamedValue* find(const Diagnosis& d, const std::string& effect, const std::string& parameter) {
  for (const EffectFinding& e : d.effects)
    if (e.effect == effect)
      for (const NamedValue& v : e.parameters)
        if (v.name == parameter) return &v;
  return nullptr;
}

TEST(ChallengeTrials, DoesNotCallASpringAConstantForce) {
  const Diagnosis d = diagnose_concealed(
      R"({type = "sindy_residual", frame = "world", terms = ["1", "px", "py"], fx = [0.02, -0.03, 0], fy = [0, 0, -0.03], fz = [0, 0, 0]})");
  EXPECT_THAT(d.effects, Each(Field(&EffectFinding::effect, Not("constant_force")))) << to_json(d).dump(1);
  EXPECT_NE(d.verdict, Verdict::consistent);
}

TEST(ChallengeTrials, SaysThatATrueEffectIsEven) {
  const Diagnosis d = diagnose_concealed(R"({type = "rotor_drag", at_hover = 0.02})");
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "rotor_drag");
  for (const double share : d.effects[0].least_even.share) EXPECT_NEAR(share, 1.0, 0.2);
  EXPECT_EQ(d.effects[0].least_even.share.size(), 3u);
}

TEST(ChallengeTrials, NamesNothingWhereEverythingIsALittleOff) {
  const Diagnosis d = diagnose_concealed(
      R"({type = "mass", delta = 0.004}, {type = "thrust_curve", curvature = 0.004}, {type = "inertia", delta_x = 0.015, delta_y = -0.015, delta_z = 0.01},
         {type = "center_of_mass", x = 3e-5, y = -3e-5, z = 2e-5}, {type = "yaw_torque_ratio", delta = -0.015}, {type = "rotor_loss", rotor = 2, loss = 0.003})");
  EXPECT_THAT(d.effects, IsEmpty()) << to_json(d).dump(1);
  EXPECT_EQ(d.verdict, Verdict::consistent);
}

TEST(GustPartsTrials, TellsTheRandomPartAndTheLine) {
  // 0.3 m/s² of a Crazyflie's 27 g each
  const Diagnosis d = diagnose_concealed(
      R"({type = "gust", sigma_xy = 0.008, sigma_z = 0.004, correlation_time = 1.0, line_amplitude = 0.012, line_frequency = 2.2})");
  const NamedValue* frequency = find(d, "gust", "line_frequency");
  ASSERT_NE(frequency, nullptr) << to_json(d).dump(1);
  EXPECT_NEAR(frequency->value, 2.2, 0.1);
  EXPECT_NEAR(find(d, "gust", "line_amplitude")->value, 0.012, 0.004);
  EXPECT_NEAR(find(d, "gust", "sigma_xy")->value, 0.008, 0.004);
  EXPECT_NEAR(find(d, "gust", "correlation_time")->value, 1.0, 0.7);
}

}  // namespace challenge_test
}  // namespace gustlab::diagnosis
