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
  EXPECT_EQ(d.rejected[2].delta_chi2, 12.0);
  EXPECT_EQ(d.rejected[2].why, "late");
}

TEST(Suspect, NothingStandsWhereNothingIsSaidOfIt) {
  Diagnosis d = with_names();
  suspect(d, "late");
  EXPECT_TRUE(d.effects.empty());
  EXPECT_EQ(d.rejected.size(), 4u);
}

}  // namespace suspect_test
}  // namespace gustlab::diagnosis
