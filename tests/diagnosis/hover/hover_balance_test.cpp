// Mean commands of hover against sums by hand.
#include "diagnosis/hover/hover_balance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace hover_balance_test {

constexpr double sample_s = 0.01;

// each rotor at a speed of its own, which swings so that none is at its highest for long
RotorArray speeds(double t) {
  RotorArray out{};
  for (std::size_t i = 0; i < 4; ++i)
    out[i] = (700.0 + 10.0 * static_cast<double>(i)) * (1.0 + 0.02 * std::sin(7.0 * t + static_cast<double>(i)));
  return out;
}

FlightData hover(const VehicleModel& vehicle, double duration_s, double speed_mps = 0.0, double climb_mps = 0.0) {
  return test::flight_of(
      vehicle, duration_s, sample_s,
      [=](double) {
        Motion motion;
        motion.velocity_W_mps = {speed_mps, 0.0, climb_mps};
        return motion;
      },
      speeds);
}

VehicleModel vehicle() { return test::ring(4, 1.5, 0.25, 0.0); }

// a rotor's thrust turns the vehicle about its centre of mass by its lever, and about its axis against its own turning
TEST(HoverBalance, WrenchOfARotorIsItsLeverAndItsReaction) {
  VehicleModel skewed = vehicle();
  skewed.rotors[1] = test::rotor(0.2, -0.1, 0.05, -1.0, 1e-5, 0.02);
  skewed.center_of_mass_B_m = {0.01, 0.02, 0.0};
  const Eigen::Vector4d wrench = wrench_per_newton(skewed, 1);
  EXPECT_LT((wrench - Eigen::Vector4d(1.0, -0.12, -0.19, 0.02)).norm(), 1e-12);
}

TEST(HoverBalance, IsTheMeanOfHalfSeconds) {
  const VehicleModel model = vehicle();
  const auto balance = hover_balance(hover(model, 7.995), model);
  ASSERT_TRUE(balance);
  // a second at each end, and blocks that begin within: 1.0 to 7.0 s
  EXPECT_NEAR(balance->hover_s, 6.0, 0.5 + 1e-9);
  const int blocks = static_cast<int>(std::lround(balance->hover_s / 0.5));
  std::vector<Eigen::Vector4d> wrench;
  Eigen::Vector4d mean = Eigen::Vector4d::Zero(), square = mean;
  std::array<double, 4> thrust_N{};
  for (int b = 0; b < blocks; ++b) {
    wrench.emplace_back(Eigen::Vector4d::Zero());
    for (int k = 0; k < 50; ++k)
      for (int i = 0; i < 4; ++i) {
        // a sample is driven by what was commanded before it
        const double speed = speeds(1.0 + 0.5 * b + sample_s * (k - 1))[static_cast<std::size_t>(i)];
        const double f = model.rotors[static_cast<std::size_t>(i)].thrust_coefficient_Ns2 * speed * speed / 50.0;
        thrust_N[static_cast<std::size_t>(i)] += f / blocks;
        wrench.back() += f * wrench_per_newton(model, i);
      }
    mean += wrench.back() / blocks;
  }
  for (const Eigen::Vector4d& w : wrench) square += (w - mean).cwiseAbs2() / (blocks * (blocks - 1.0));
  EXPECT_LT((balance->wrench - mean).norm(), 1e-9 * mean.norm());
  EXPECT_LT((balance->deviation - square.cwiseSqrt()).norm(), 1e-6 * square.cwiseSqrt().norm());
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(balance->thrust_N[i], thrust_N[i], 1e-9);
    EXPECT_FALSE(balance->limited[i]) << i;
  }
}

TEST(HoverBalance, NeedsSlowFlightForLongEnough) {
  const VehicleModel model = vehicle();
  EXPECT_FALSE(hover_balance(hover(model, 4.0), model));
  EXPECT_FALSE(hover_balance(hover(model, 8.0, 0.4), model));
  EXPECT_FALSE(hover_balance(hover(model, 8.0, 0.0, -0.2), model));
  FlightData blind = hover(model, 8.0);
  for (Sample& sample : blind.samples) sample.channels = has_attitude | has_rate;
  EXPECT_FALSE(hover_balance(blind, model));
  FlightData collective = hover(model, 8.0);
  collective.collective_only = true;
  EXPECT_FALSE(hover_balance(collective, model));
  EXPECT_FALSE(hover_balance(FlightData{}, model));
}

TEST(HoverBalance, SaysWhichRotorIsAtItsLimit) {
  VehicleModel model = vehicle();
  FlightData flight = hover(model, 8.0);
  flight.commands = test::record_of(
      [](double t) {
        RotorArray all = speeds(t);
        all[2] = 715.0;
        return all;
      },
      8.0, sample_s, false);
  auto balance = hover_balance(flight, model);
  ASSERT_TRUE(balance);
  EXPECT_EQ(balance->limited, (std::vector<bool>{false, false, true, false}));
  // an empty battery gives the last rotor less than it is asked for: 730 of 1000 x 0.725 rad/s
  flight.commands = test::record_of(speeds, 8.0, sample_s, false);
  flight.has_voltage = true;
  model.nominal_voltage_V = 4.0;
  for (Sample& sample : flight.samples) sample.voltage_V = 2.9;
  balance = hover_balance(flight, model);
  ASSERT_TRUE(balance);
  EXPECT_EQ(balance->limited, (std::vector<bool>{false, false, false, true}));
}

}  // namespace hover_balance_test
}  // namespace gustlab::diagnosis
