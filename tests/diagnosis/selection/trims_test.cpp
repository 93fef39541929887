// Sizes in reporting tolerances by hand, and scatter that imitates an effect: on the catalogue of a flight that is a formula.
#include "diagnosis/selection/trims.hpp"

#include "diagnosis/result/decisions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "diagnosis/selection/wind_start.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace trims_test {

class Trims : public ::testing::Test {
 protected:
  static Session make() {
    const VehicleModel vehicle = test::crazyflie();
    FlightData flight = test::flight_of(
        vehicle, 1.0, 0.01, [](double) { return Motion{}; },
        [&](double) { return test::all_at(vehicle.hover_speed_radps()); });
    flight.hold_known = true;
    return Session({flight}, vehicle, 1);
  }
  const Column& column(int c) const { return session_.catalogue().column(c); }
  Eigen::VectorXd nominal() const {
    Eigen::VectorXd value(session_.catalogue().size());
    for (int c = 0; c < session_.catalogue().size(); ++c) value[c] = column(c).nominal;
    return value;
  }
  // groups all of whose columns have a tolerance, and one that has none
  int group_with_tolerance(std::size_t columns) const {
    const auto& groups = session_.catalogue().groups();
    for (std::size_t g = 0; g < groups.size(); ++g)
      if (groups[g].columns.size() == columns && std::all_of(groups[g].columns.begin(), groups[g].columns.end(),
                                                             [&](int c) { return column(c).tolerance > 0.0; }))
        return static_cast<int>(g);
    return -1;
  }
  const std::vector<int>& columns_of(int group) const { return session_.catalogue().group(group).columns; }
  Session session_ = make();
};

TEST_F(Trims, SizeIsOfTheLargestColumnEitherWay) {
  const int group = group_with_tolerance(3);
  ASSERT_GE(group, 0);
  const std::vector<int>& own = columns_of(group);
  Eigen::VectorXd value = nominal();
  EXPECT_EQ(size_in_tolerances(session_, value, group), 0.0);
  value[own[0]] += 0.4 * column(own[0]).tolerance;
  value[own[1]] -= 0.9 * column(own[1]).tolerance;
  EXPECT_NEAR(size_in_tolerances(session_, value, group), 0.9, 1e-9);
  EXPECT_TRUE(below_tolerance(session_, value, group));
  value[own[2]] += 1.3 * column(own[2]).tolerance;  // a fifth more than the tolerance is no trim
  EXPECT_FALSE(below_tolerance(session_, value, group));
}

TEST_F(Trims, WithoutAToleranceNothingIsATrim) {
  const auto& groups = session_.catalogue().groups();
  int found = 0;
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (std::any_of(groups[g].columns.begin(), groups[g].columns.end(),
                    [&](int c) { return column(c).tolerance == 0.0; })) {
      EXPECT_TRUE(std::isinf(size_in_tolerances(session_, nominal(), static_cast<int>(g))));
      ++found;
    }
  EXPECT_GT(found, 0);
}

TEST_F(Trims, BesideFlightsThatHaveForcesOfTheirOwnAForceMustBeLarger) {
  const int group = force_like_wind(session_.catalogue());
  const std::string label = session_.catalogue().group(group).label;
  Eigen::VectorXd value = nominal();
  value[columns_of(group).front()] = 0.06;
  EXPECT_TRUE(std::isinf(size_in_tolerances(session_, value, group)));
  Reference reference;
  for (const int parameter : {0, 1, 2}) reference.of_each_flight[{label, parameter}] = 0.02;
  session_.compare_with(reference);
  EXPECT_NEAR(size_in_tolerances(session_, value, group), 1.0, 1e-12);
  value[columns_of(group).front()] = 0.12;
  EXPECT_NEAR(size_in_tolerances(session_, value, group), 2.0, 1e-12);
}

TEST_F(Trims, BesideAreAllOthersWithATolerance) {
  const std::vector<int>& own = columns_of(group_with_tolerance(1));
  const std::vector<Trim> trims = trims_beside(session_, own, 0.5);
  int expected = 0;
  for (int c = 0; c < session_.catalogue().size(); ++c) expected += column(c).tolerance > 0.0 && c != own.front();
  EXPECT_EQ(std::ssize(trims), expected);
  for (const Trim& trim : trims) {
    EXPECT_NE(trim.column, own.front());
    EXPECT_NEAR(trim.deviation * column(trim.column).natural, 0.5 * column(trim.column).tolerance, 1e-15);
  }
}

// one row of information: z is the column's own signature. Where another trim has the same signature, a little of each explains it.
TEST_F(Trims, ASignatureThatScatterHasTooIsImitated) {
  const int group = group_with_tolerance(1);
  ASSERT_GE(group, 0);
  const int own = columns_of(group).front(), size = session_.catalogue().size();
  int other = -1;
  for (const Trim& trim : trims_beside(session_, {own}, 1.0))
    if (column(trim.column).group >= 0 && column(trim.column).group != group) other = trim.column;
  ASSERT_GE(other, 0);
  const double share = decisions::trim_share * column(own).tolerance / column(own).natural;
  // strength: what the scatter's own deviation leaves of the value, 20 times it, in units of the cost
  const double value = 20.0 * share, scale = 10.0 * decisions::trim_cost / (value * value);
  const auto gram = [&](double of_other) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(size + 1);
    row[own] = 1.0, row[other] = of_other, row[size] = value;
    return Eigen::MatrixXd(scale * row * row.transpose());
  };
  EXPECT_FALSE(imitated_by_scatter(session_, gram(0.0), {group}, group));
  // its deviation times this signature is a hundred times the value
  const double loud = 100.0 * value / (decisions::trim_share * column(other).tolerance / column(other).natural);
  EXPECT_TRUE(imitated_by_scatter(session_, gram(loud), {group}, group));
}

}  // namespace trims_test
}  // namespace gustlab::diagnosis
