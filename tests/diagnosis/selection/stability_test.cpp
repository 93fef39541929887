// Shares of half samples whose answer is known: halves are complementary, so one second is in exactly one of each two.
#include "diagnosis/selection/stability.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace stability_test {

constexpr int clusters = 12, rows_per_block = 60;

class Stability : public ::testing::Test {
 protected:
  static Session make() {
    VehicleModel vehicle = test::crazyflie();
    vehicle.effects.clear();
    return Session({test::flight_of(
                       vehicle, 1.0, 0.01, [](double) { return Motion{}; },
                       [&](double) { return test::all_at(vehicle.hover_speed_radps()); })},
                   vehicle, 1);
  }
  int column(const char* name) const {
    return session.catalogue().group(session.catalogue().find(name)).columns.front();
  }
  // all columns are chance; z is chance too, and `always` of one column in every second, `once` of another in the first
  Grams grams(double always, double once) const {
    const RandomStream random(5, 0, "stability_test");
    Grams result;
    result.columns = session.catalogue().size();
    result.clusters = clusters;
    std::uint64_t at = 0;
    for (int b = 0; b < 2 * clusters; ++b) {
      Eigen::MatrixXd rows(rows_per_block, result.columns + 1);
      for (double& value : rows.reshaped()) value = random.normal4(at++)[0];
      rows.rightCols<1>() += always * rows.col(column("mass"));
      if (b < 2) rows.rightCols<1>() += once * rows.col(column("rotor_drag"));
      result.block.push_back(rows.transpose() * rows);
      result.cluster.push_back(b / 2);
      result.known.push_back(false);
      result.flight.push_back(0);
      result.time_s.push_back(0.5 * b);
    }
    result.rows = 2.0 * clusters * rows_per_block;
    return result;
  }
  double share(const std::vector<double>& shares, const char* name) const {
    return shares[static_cast<std::size_t>(session.catalogue().find(name))];
  }
  Session session = make();
};

TEST_F(Stability, WhatIsInEverySecondIsInEveryHalfAndWhatIsInOneInOneOfTwo) {
  const std::vector<int> chosen = {session.catalogue().find("mass"), session.catalogue().find("rotor_drag")};
  const std::vector<double> shares = inclusion(session, grams(5.0, 6.0), chosen);
  EXPECT_EQ(share(shares, "mass"), 1.0);
  EXPECT_EQ(share(shares, "rotor_drag"), 0.5);
  // chance stands in for what a half has not, and for nothing else
  EXPECT_LE(std::accumulate(shares.begin(), shares.end(), 0.0), 2.0);
}

TEST_F(Stability, WhatIsLeftOutIsInNoHalf) {
  const int mass = session.catalogue().find("mass"), drag = session.catalogue().find("rotor_drag");
  const std::vector<double> shares = inclusion(session, grams(5.0, 6.0), {mass, drag}, {mass});
  EXPECT_EQ(share(shares, "mass"), 0.0);
  EXPECT_NEAR(share(shares, "rotor_drag"), 0.5, 0.05);
}

// that a nuisance is small is known in every half, or nothing would be found beside it in one that has not drawn it
TEST_F(Stability, WhatIsKnownBeforehandIsInEveryHalf) {
  const int mass = column("mass"), bias = session.biases().front();
  Grams flown = grams(5.0, 0.0);
  for (Eigen::MatrixXd& block : flown.block) block.row(bias) = block.row(mass), block.col(bias) = block.col(mass);
  const std::vector<int> chosen = {session.catalogue().find("mass")};
  EXPECT_EQ(share(inclusion(session, flown, chosen), "mass"), 0.0);
  Eigen::MatrixXd small = Eigen::MatrixXd::Zero(flown.columns + 1, flown.columns + 1);
  small(bias, bias) = 1e9;
  flown.add(0, 0.0, small, true);
  EXPECT_EQ(share(inclusion(session, flown, chosen), "mass"), 1.0);
}

TEST_F(Stability, OfNothingThatWasChosenThereIsNothingToAsk) {
  for (const double s : inclusion(session, grams(5.0, 0.0), {})) EXPECT_EQ(s, 0.0);
}

}  // namespace stability_test
}  // namespace gustlab::diagnosis
