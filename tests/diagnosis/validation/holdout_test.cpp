// What a fit knows of flights that it has not seen.
#include "diagnosis/validation/holdout.hpp"

#include <gtest/gtest.h>

#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace {

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

}  // namespace
}  // namespace gustlab::diagnosis
