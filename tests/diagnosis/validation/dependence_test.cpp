// Series that are moved along their own flights.
#include "diagnosis/validation/dependence.hpp"

#include <gtest/gtest.h>

namespace gustlab::diagnosis {
namespace dependence_test {

TEST(Dependence, EveryFlightIsMovedInItsOwnCircle) {
  const Eigen::VectorXd y{{1.0, 2.0, 3.0, 4.0, 10.0, 20.0, 30.0, 7.0}};
  const std::vector<int> flight = {0, 0, 0, 0, 1, 1, 1, 2};
  EXPECT_EQ(moved_along(y, flight, 0), y);
  EXPECT_EQ(moved_along(y, flight, 1), (Eigen::VectorXd{{2.0, 3.0, 4.0, 1.0, 20.0, 30.0, 10.0, 7.0}}));
  EXPECT_EQ(moved_along(y, flight, 12), y);  // whole turns of all three
  EXPECT_EQ(moved_along(moved_along(y, flight, 5), flight, 7), y);
}

}  // namespace dependence_test
}  // namespace gustlab::diagnosis
