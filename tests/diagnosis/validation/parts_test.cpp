// A push and a turning that belong together are of one size.
#include <gmock/gmock.h>

#include "diagnosis/validation/parts.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::Field;
using ::testing::Not;

Diagnosis diagnose_concealed(const std::string& concealed) {
  const TemporaryFolder folder;
  test::TrialSettings trial;
  trial.fit = {"multisine", "lemniscate"};
  trial.holdout = {"multisine"};
  trial.concealed = concealed;
  return diagnose(test::fly_trial(folder, trial));
}

TEST(Parts, AreUnevenOnlyBeyondChanceAndByMuch) {
  EXPECT_FALSE((Parts{0.0, 0.0}).uneven());
  EXPECT_FALSE((Parts{-0.25, 0.01}).uneven());
  EXPECT_FALSE((Parts{0.4, 0.05}).uneven());
  EXPECT_FALSE((Parts{-0.6, 0.25}).uneven());
  EXPECT_TRUE((Parts{-0.6, 0.18}).uneven());
  EXPECT_TRUE((Parts{0.6, 0.04}).uneven());
  EXPECT_FALSE((Parts{0.6, 0.04, true}).uneven());
  EXPECT_TRUE((Parts{-0.6, 0.04, true}).uneven());
}

TEST(Parts, OfAnInflowAgree) {
  const Diagnosis d = diagnose_concealed(R"({type = "axial_inflow", at_hover = 0.02})");
  EXPECT_THAT(d.effects, Contains(Field(&EffectFinding::effect, "axial_inflow"))) << to_json(d).dump(1);
}

// it turns the vehicle as an inflow would, and does not push
TEST(Parts, OfADampingAloneAreNoInflow) {
  const Diagnosis d = diagnose_concealed(
      R"({type = "axial_inflow", at_hover = 0.02}, {type = "sindy_residual", frame = "world", terms = ["vz"], fx = [0], fy = [0], fz = [0.02]})");
  EXPECT_THAT(d.effects, Each(Field(&EffectFinding::effect, Not("axial_inflow")))) << to_json(d).dump(1);
}

}  // namespace
}  // namespace gustlab::diagnosis
