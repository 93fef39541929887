// Names that are withdrawn are said to be, with the reason, and those that stand keep their order.
#include "diagnosis/evidence/suspect.hpp"

#include <gtest/gtest.h>

namespace gustlab::diagnosis {
namespace suspect_test {

Diagnosis with_names() {
  Diagnosis d;
  for (const char* name : {"first", "second", "third"}) {
    EffectFinding effect;
    effect.effect = name;
    effect.delta_chi2 = 10.0 + static_cast<double>(d.effects.size());
    effect.price = 4.0;
    d.effects.push_back(effect);
  }
  d.rejected.push_back({"before", 1.0, "earlier"});
  return d;
}

TEST(Suspect, WithdrawsAllButThoseThatStand) {
  Diagnosis d = with_names();
  suspect(d, "late", [](const EffectFinding& e) { return e.effect == "second"; });
  ASSERT_EQ(d.effects.size(), 1u);
  EXPECT_EQ(d.effects[0].effect, "second");
  ASSERT_EQ(d.rejected.size(), 3u);
  EXPECT_EQ(d.rejected[0].effect, "before");
  EXPECT_EQ(d.rejected[1].effect, "first");
  EXPECT_EQ(d.rejected[2].effect, "third");
  EXPECT_EQ(d.rejected[2].score, 8.0);  // beyond what its numbers cost
  EXPECT_EQ(d.rejected[2].why, "late");
}

TEST(Suspect, SaysOfWhichRotor) {
  Diagnosis d;
  for (const double rotor : {2.0, 3.0}) {
    EffectFinding& loss = d.effects.emplace_back();
    loss.effect = "rotor_loss", loss.parameters = {{"rotor", "-", rotor, 0.0}};
  }
  suspect(d, "late");
  ASSERT_EQ(d.rejected.size(), 2u);
  EXPECT_EQ(d.rejected[0].effect, "rotor_loss (rotor 2)");
  EXPECT_EQ(d.rejected[1].effect, "rotor_loss (rotor 3)");
}

TEST(Suspect, NothingStandsWhereNothingIsSaidOfIt) {
  Diagnosis d = with_names();
  suspect(d, "late");
  EXPECT_TRUE(d.effects.empty());
  EXPECT_EQ(d.rejected.size(), 4u);
}

}  // namespace suspect_test
}  // namespace gustlab::diagnosis
