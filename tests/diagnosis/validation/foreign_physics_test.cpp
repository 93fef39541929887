// Names beside physics that no catalogue holds, and logs that were smoothed before they were written.
#include "diagnosis/diagnose.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/validation/regimes.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace foreign_physics_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const char* const spring =
    R"({type = "sindy_residual", frame = "world", terms = ["1", "px", "py"], fx = [0.02, -0.06, 0], fy = [0, 0, -0.06], fz = [0, 0, 0]})";

test::TrialSettings settings(const std::string& concealed, double noise = 1.0) {
  return {.fit = {"lemniscate", "multisine"},
          .holdout = {"circle"},
          .duration_s = 9.0,
          .noise = noise,
          .concealed = concealed};
}

// Forward and backward through a filter of first order, twice: what was measured alone, as labs do before they publish. A quiet
// gyro, because a smoothed command hides the thrust that a noisy one makes.
constexpr double quiet = 0.1;
void smooth(const DiagnoseOptions& trial, double time_constant_s) {
  const auto measured = [](const std::string& name) { return !is_rotor_column(name); };
  test::change(trial, measured, [&](const FlightLog& log, std::vector<double>& values) {
    const double keep = std::exp(-(log.time_s[1] - log.time_s[0]) / time_constant_s);
    const auto once = [&](auto first, auto last) {
      for (double state = *first; first != last; ++first) *first = state = keep * state + (1.0 - keep) * *first;
    };
    for (int pass = 0; pass < 2; ++pass) once(values.begin(), values.end()), once(values.rbegin(), values.rend());
  });
}

TEST(ForeignPhysicsTrials, LatePoseStandsWhereGyroAndAttitudesTellIt) {
  const TemporaryFolder folder;
  const Diagnosis d =
      diagnose(test::fly_trial(folder, settings(std::string(spring) + R"(, {type = "pose_delay", delay = 0.015})")));
  ASSERT_THAT(d.alarms, Not(IsEmpty()));
  ASSERT_THAT(d.effects, ElementsAre(Field(&EffectFinding::effect, "pose_delay"))) << to_json(d).dump(1);
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.015, 0.002);
  EXPECT_EQ(d.verdict, Verdict::partly_explained);
}

TEST(Regimes, EvenMeansAlikeInEveryRegime) {
  Regimes even{.variable = "speed", .share = {1.0, 1.0, 1.0}, .deviation = {0.05, 0.05, 0.05}};
  EXPECT_NEAR(most_astray({even}), 0.05 * std::sqrt(2.0), 1e-12);
  Regimes uneven = even;
  uneven.share = {0.6, 1.0, 1.4};
  uneven.spread = 0.4;
  EXPECT_GT(most_astray({even, uneven}), 0.4);
  Regimes untold = even;
  untold.deviation = {0.05, 0.05, 1.0};
  EXPECT_EQ(most_astray({even, untold}), 1.0);
}

TEST(SmoothedLogTrials, IsSaidAndItsDragNamed) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, settings(R"({type = "rotor_drag", at_hover = 0.02})", quiet));
  smooth(trial, 0.01);
  const Diagnosis d = diagnose(trial);
  EXPECT_THAT(d.log_findings, Contains(Field(&LogFinding::kind, "filtered")));
  ASSERT_THAT(d.effects, ElementsAre(Field(&EffectFinding::effect, "rotor_drag"))) << to_json(d).dump(1);
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.02, 0.003);
  EXPECT_THAT(d.not_identifiable, Contains(AllOf(Field(&NotIdentifiable::effect, "steady_wind"),
                                                 Field(&NotIdentifiable::why, HasSubstr("see constant_force")))));
  EXPECT_THAT(d.notes, Contains(HasSubstr("which smoothed the motion and not the commands")));
}

TEST(SmoothedLogTrials, WithoutMissingPhysicsNamesNothing) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, settings("", quiet));
  smooth(trial, 0.01);
  EXPECT_THAT(diagnose(trial).effects, IsEmpty());
}

}  // namespace foreign_physics_test
}  // namespace gustlab::diagnosis
