// A name of an unusual size and an equal rival of a usual one: which of the two is the answer.
#include "diagnosis/evidence/usual_names.hpp"

#include <gtest/gtest.h>

#include "diagnosis/selection/select_effects.hpp"
#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace usual_names_test {

class UsualNames : public ::testing::Test {
 protected:
  Session session = test::session_of(test::short_flights(R"({type = "thrust_scale", delta = -0.2})", {"multisine"}));
  const Catalogue& catalogue = session.catalogue();
  const int scale = catalogue.find("thrust_scale"), mass = catalogue.find("mass"),
            force = catalogue.find("constant_force");
  Selection selection = select_effects(session);
  Challenge judged = as_judged(selection, 0.9);
  int asked = 0;  // sets that were judged

  static Challenge as_judged(const Selection& selection, double probability) {
    Challenge result;
    for (const Finding& finding : selection.findings) {
      Evidence& record = result.records.emplace_back();
      record.group = finding.group;
      record.probability = probability;
    }
    result.history.push_back({.names = {}, .withdrawn = {}, .in_its_place = {}, .answer = true});
    return result;
  }

  Finding& the_scale() {
    for (Finding& finding : selection.findings)
      if (finding.group == scale) return finding;
    throw std::logic_error("no thrust scale was found");
  }

  void say(double probability) {
    say_usual_names(session, selection, judged, [&](Selection& other) {
      ++asked;
      return as_judged(other, probability);
    });
  }
};

TEST_F(UsualNames, AnEqualRivalOfAUsualSizeIsTheAnswer) {
  the_scale().rivals = {{mass, 0.0, 1.0, false, 1.0}};
  say(0.9);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(selection.find(scale), nullptr);
  ASSERT_NE(selection.find(mass), nullptr);
  EXPECT_NEAR(selection.value[catalogue.group(mass).columns.front()], 0.25, 0.01);
  EXPECT_EQ(judged.records.size(), selection.findings.size());
  ASSERT_EQ(judged.history.size(), 2u);  // what was judged before is kept
  EXPECT_FALSE(judged.history.front().answer);
  EXPECT_EQ(judged.history.front().withdrawn, std::vector<std::string>{"thrust_scale"});
  EXPECT_EQ(judged.history.front().in_its_place, "mass");
  EXPECT_TRUE(judged.history.back().answer);
}

TEST_F(UsualNames, OneThatCostsANameIsNot) {
  the_scale().rivals = {{mass, 0.0, 1.0, false, 1.0}};
  const Eigen::VectorXd value = selection.value;
  say(0.7);
  EXPECT_EQ(asked, 1);
  EXPECT_NE(selection.find(scale), nullptr);
  EXPECT_EQ(selection.value, value);
  EXPECT_EQ(judged.history.size(), 1u);
}

TEST_F(UsualNames, OneThatIsToldOrHardlySmallerIsNotAsked) {
  Finding& finding = the_scale();
  ASSERT_GT(size_in_naturals(catalogue, selection.value, scale), 3.0);
  finding.rivals = {{mass, 9.0, 0.4 * finding.delta_chi2, false, 1.0},
                    {force, 0.0, 1.0, false, 3.0},
                    {catalogue.find("slung_load"), 0.0, 1.0, true, 1.0}};
  EXPECT_EQ(far_more_usual_rival(catalogue, selection, finding, {}), std::nullopt);
  finding.rivals = {{force, 0.0, 1.0, false, 1.5}, {mass, 0.0, 2.0, false, 1.0}};
  EXPECT_EQ(far_more_usual_rival(catalogue, selection, finding, {})->group, mass);
  EXPECT_EQ(far_more_usual_rival(catalogue, selection, finding, {mass})->group, force);
}

}  // namespace usual_names_test
}  // namespace gustlab::diagnosis
