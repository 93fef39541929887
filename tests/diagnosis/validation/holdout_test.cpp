// What a fit knows of flights that it has not seen.
#include "diagnosis/validation/holdout.hpp"

#include <gtest/gtest.h>

#include "diagnosis/evidence/reference_fit.hpp"
#include "diagnosis/selection/select_effects.hpp"
#include "support/sessions.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace holdout_test {

Catalogue catalogue(int flights) {
  return {test::crazyflie(), flights, {.observable = Need::attitude | Need::motion | Need::torque}};
}

const Column& column(const Catalogue& of, int c) { return of.column(c); }

TEST(CarryOver, TakesSharedValuesAsTheyAreAndThoseOfFlightsAtTheirMean) {
  const Catalogue from = catalogue(3), to = catalogue(2);
  Eigen::VectorXd value = from.nominal();
  for (int c = 0; c < from.size(); ++c)
    value[c] = 1.0 + column(from, c).parameter + (column(from, c).flight < 0 ? 0.0 : 10.0 * column(from, c).flight);
  const Eigen::VectorXd carried = carry_over(from, value, to);
  int shared = 0, own = 0;
  for (int c = 0; c < to.size(); ++c) {
    const Column& at = column(to, c);
    // biases belong to their flight; flights 0, 1 and 2 have 0, 10 and 20 more
    const double expected = at.group < 0 ? at.nominal : at.flight >= 0 ? 11.0 + at.parameter : 1.0 + at.parameter;
    EXPECT_NEAR(carried[c], expected, 1e-12) << at.name;
    if (at.group >= 0) ++(at.flight >= 0 ? own : shared);
  }
  EXPECT_GE(own, 6);
  EXPECT_GE(shared, 10);
}

// a reference flight hardly tells a mass from a thrust scale: where one of the two alone could be wrong of it, it would explain the change as well
TEST(HoldOutTrials, BesideReferenceFlightsAChangeSaysWhatItSaysOfTheOthers) {
  const Recordings good = test::short_flights("", {"multisine", "lemniscate"}),
                   heavier = test::short_flights(R"({type = "mass", delta = 0.1})", {"multisine"});
  ReferenceFit normal = ReferenceFlights(test::session_of(good).flights(), {}, good.fit, good.vehicle, 1).fit();
  Session session(prepare(heavier.fit, normal.vehicle, {}), normal.vehicle, 1);
  session.compare_with(std::move(normal.known));
  const Selection selection = select_effects(session);
  ASSERT_EQ(selection.findings.size(), 1u);
  EXPECT_GT(selection.findings[0].delta_chi2, 100.0);
  const HoldoutTest test = test_holdout(session, selection, prepare(heavier.holdout, normal.vehicle, {}), {}, 1);
  EXPECT_GT(test.expected[0], 0.3 * selection.findings[0].delta_chi2);
  EXPECT_NEAR(test.delta_chi2[0], test.expected[0], 0.3 * test.expected[0]);
}

}  // namespace holdout_test
}  // namespace gustlab::diagnosis
