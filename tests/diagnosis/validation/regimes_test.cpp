// An effect of known size in each part of a flight: blocks whose coefficient is put in by hand.
#include "diagnosis/validation/regimes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/validation/remainder.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace regimes_test {

constexpr int blocks = 60;

class RegimesOf : public ::testing::Test {
 protected:
  static Session make() {
    VehicleModel vehicle = test::crazyflie();
    vehicle.effects.clear();
    // higher and higher
    const auto climb = [](double t) {
      Motion motion;
      motion.position_W_m.z() = 0.1 * t;
      return motion;
    };
    return Session({test::flight_of(vehicle, 0.5 * blocks, 0.02, climb,
                                    [&](double) { return test::all_at(vehicle.hover_speed_radps()); })},
                   vehicle, 1);
  }
  // of one finding with coefficient 1, which is `size(block)` in each block; every block tells as much of it
  template <class Size>
  std::vector<Regimes> along(const Size& size) const {
    const int mass = session.catalogue().find("mass"), z = session.catalogue().size();
    const int c = session.catalogue().group(mass).columns.front();
    Selection selection;
    selection.findings.resize(1);
    selection.findings[0].group = mass;
    selection.value = session.catalogue().nominal();
    selection.value[c] += session.catalogue().column(c).natural;
    selection.grams.columns = z;
    selection.grams.clusters = blocks;
    for (int b = 0; b < blocks; ++b) {
      Eigen::MatrixXd block = Eigen::MatrixXd::Zero(z + 1, z + 1);
      block(c, c) = 10.0, block(c, z) = block(z, c) = 10.0 * size(b), block(z, z) = 10.0 * size(b) * size(b);
      selection.grams.block.push_back(block);
      selection.grams.flight.push_back(0);
      selection.grams.cluster.push_back(b);
      selection.grams.known.push_back(false);
      selection.grams.time_s.push_back(0.5 * b);
    }
    return regimes(session, selection).front();
  }
  static const Regimes& of(const std::vector<Regimes>& all, const char* variable) {
    return *std::find_if(all.begin(), all.end(), [&](const Regimes& r) { return r.variable == variable; });
  }
  const Session session = make();
};

TEST_F(RegimesOf, AreItsSizesWhereAVariableIsLowMiddlingAndHigh) {
  // alternating by ±.06, and larger with height
  const auto all = along([](int b) { return (b < 20 ? 0.5 : b < 40 ? 1.0 : 1.5) + (b % 2 == 0 ? 0.06 : -0.06); });
  const Regimes& height = of(all, "height");
  for (std::size_t p = 0; p < 3; ++p) {
    EXPECT_NEAR(height.share[p], 0.5 + 0.5 * static_cast<double>(p), 1e-9);
    EXPECT_NEAR(height.deviation[p], 0.06 / std::sqrt(20.0), 1e-3);
  }
  EXPECT_NEAR(height.spread, std::sqrt(0.25 - 0.06 * 0.06 / 20.0), 1e-6);
  EXPECT_GT(most_astray(all), 0.49);
  EXPECT_EQ(surely_astray(all), all.front().spread);
  // the widest comes first
  for (std::size_t i = 1; i < all.size(); ++i) EXPECT_GE(all[i - 1].spread, all[i].spread);
}

TEST_F(RegimesOf, OfAnEvenEffectSpreadNowhere) {
  const auto all = along([](int b) { return b % 2 == 0 ? 1.06 : 0.94; });
  EXPECT_EQ(of(all, "height").spread, 0.0);
  EXPECT_LT(most_astray(all), 0.05);
}

// half as large and half again as large, but every block says something else by four times as much
TEST_F(RegimesOf, WhatMayBeChanceIsNotSurelyAstray) {
  const auto all = along([](int b) { return 0.5 + 0.5 * (b / 20) + (b % 2 == 0 ? 2.0 : -2.0); });
  EXPECT_GT(most_astray(all), 0.2);
  EXPECT_EQ(surely_astray(all), 0.0);
}

// variables of which few clusters say anything do not count, and where most are such nothing is known
TEST(MostAstray, IsUnknownWhereMostRegimesAre) {
  const Regimes even{"height", {1.0, 1.0, 1.0}, {0.05, 0.05, 0.05}, 0.0, 0.0},
      unknown{"speed", {1.0, 1.0, 1.0}, {0.05, 1.0, 0.05}, 0.8, 0.0};
  EXPECT_LT(most_astray({even, even, unknown}), 0.1);
  EXPECT_EQ(most_astray({even, unknown}), 1.0);
  EXPECT_EQ(most_astray({even, unknown, unknown}), 1.0);
  EXPECT_EQ(surely_astray({even, unknown}), 0.0);
}

// χ² of `size` unknowns has that mean and twice that variance; a thousandth of the rows is nothing to speak of
TEST(BeyondChance, IsFarMoreThanTheMeanOfChiSquared) {
  EXPECT_FALSE(beyond_chance(12.0, 12, 0.0));
  EXPECT_TRUE(beyond_chance(12.0 + 7.0 * std::sqrt(24.0), 12, 0.0));
  EXPECT_FALSE(beyond_chance(12.0 + 7.0 * std::sqrt(24.0), 12, 1e6));
}

}  // namespace regimes_test
}  // namespace gustlab::diagnosis
