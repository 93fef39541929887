#include "diagnosis/selection/selection.hpp"

#include <gmock/gmock.h>

namespace gustlab::diagnosis {
namespace selection_test {

using ::testing::ElementsAre;

TEST(Selection, FindsAFindingByItsGroup) {
  Selection selection;
  for (const auto& [group, delta_chi2] : {std::pair{4, 30.0}, {11, 20.0}}) {
    Finding& finding = selection.findings.emplace_back();
    finding.group = group;
    finding.delta_chi2 = delta_chi2;
  }
  EXPECT_THAT(selection.groups(), ElementsAre(4, 11));
  ASSERT_NE(selection.find(11), nullptr);
  EXPECT_EQ(selection.find(11)->delta_chi2, 20.0);
  EXPECT_EQ(selection.find(5), nullptr);
}

// a mass and a thrust scale of a quiet log: the sign of their difference is sure, and its size is rounding
TEST(Selection, OfADifferenceOfNoSizeIsAClass) {
  Finding mass;
  mass.delta_chi2 = 300.0;
  Rival scale;
  scale.z = 3.4;
  scale.delta_chi2 = 1e-4;
  EXPECT_TRUE(equal(scale, mass));
  scale.delta_chi2 = 20.0;
  EXPECT_TRUE(is_told(scale));
  EXPECT_FALSE(equal(scale, mass));
  // of a name that gains so much, a model of 3 % of its size
  mass.delta_chi2 = 3e5;
  EXPECT_TRUE(equal(scale, mass));
}

TEST(Selection, AnUnusualSizeIsComparedWithAFarSmallerOne) {
  EXPECT_TRUE(is_far_more_usual(2.0, 10.0));
  EXPECT_FALSE(is_far_more_usual(6.0, 10.0));
  EXPECT_FALSE(is_far_more_usual(0.5, 2.0));  // both are usual
}

}  // namespace selection_test
}  // namespace gustlab::diagnosis
