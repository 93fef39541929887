// What commands tell of sensors that were not logged: nothing when they follow the log, the other sensor's noise when they do not.
#include "diagnosis/model/command_innovation.hpp"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace command_innovation_test {

using ::testing::IsEmpty;

constexpr double gyro_sd_radps = 0.05,
                 gain_ps = 400.0;  // of the controller: commanded speed, rad/s per rad/s of roll rate

// 30 s at 100 Hz: a roll rate that wanders, its gyro, and rotors that answer this gyro or another one with the same noise
FlightData flown(bool same_gyro) {
  FlightData flight;
  flight.vehicle = test::crazyflie();
  flight.sample_s = 0.01;
  flight.substeps = 1;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  double rate = 0.0;
  for (int k = 0; k < 3000; ++k) {
    rate = 0.95 * rate + 0.1 * normal(random);
    Sample sample{.time_s = 0.01 * k, .channels = has_rate, .starts_segment = k == 0};
    sample.body_rate_B_radps.x() = rate + gyro_sd_radps * normal(random);
    const double read = same_gyro ? sample.body_rate_B_radps.x() : rate + gyro_sd_radps * normal(random);
    flight.samples.push_back(sample);
    RotorArray row{};
    for (std::size_t i = 0; i < 4; ++i)
      row[i] =
          flight.vehicle.hover_speed_radps() - std::copysign(gain_ps, flight.vehicle.rotors[i].position_B_m.y()) * read;
    time_s.push_back(sample.time_s);
    speed.push_back(row);
  }
  flight.commands = CommandRecord(time_s, speed, false);
  return flight;
}

double rms(const std::vector<CommandInnovation>& innovation, Eigen::Index of) {
  double sum = 0.0;
  for (const CommandInnovation& s : innovation) sum += s[of] * s[of];
  return std::sqrt(sum / static_cast<double>(innovation.size()));
}

TEST(CommandInnovationOf, IsSmallWhereCommandsFollowTheLog) {
  const double follows = rms(command_innovation(flown(true)), 0), differs = rms(command_innovation(flown(false)), 0);
  ASSERT_GT(differs, 0.0);
  EXPECT_LT(follows, 0.1 * differs);
}

TEST(CommandInnovationOf, RemembersWhatItWas) {
  const std::vector<CommandInnovation> innovation = command_innovation(flown(false));
  ASSERT_EQ(innovation.size(), 3000u);
  EXPECT_EQ(innovation.front(), CommandInnovation::Zero());
  double together = 0.0;
  for (std::size_t k = 1; k < innovation.size(); ++k) together += innovation[k][4] * innovation[k - 1][0];
  EXPECT_GT(together, 0.0);
  EXPECT_LT(rms(innovation, 4), rms(innovation, 0));
  // m⁺ = a m + b i, with a + b = 1: a mean is remembered as it is
  Eigen::Matrix2d A;
  Eigen::Vector2d next;
  for (int i = 0; i < 2; ++i) {
    const std::size_t k = 500 + static_cast<std::size_t>(i);
    A.row(i) << innovation[k][4], innovation[k][0];
    next[i] = innovation[k + 1][4];
  }
  const Eigen::Vector2d weight = A.inverse() * next;
  EXPECT_NEAR(weight.sum(), 1.0, 1e-6);
  EXPECT_GT(weight[0], 0.5);
  // roll alone was not predicted
  EXPECT_LT(rms(innovation, 1), 0.01 * rms(innovation, 0));
}

// a mean has a coefficient of its own, which no ridge holds back: a climb of 2 m/s² is predicted to the last digit
TEST(CommandInnovationOf, HasNoMean) {
  FlightData flight = flown(false);
  std::vector<RotorArray> speed = flight.commands.speed_radps();
  for (RotorArray& row : speed)
    for (double& of_rotor : row) of_rotor *= 1.1;
  flight.commands = CommandRecord(flight.commands.time_s(), speed, false);
  CommandInnovation sum = CommandInnovation::Zero();
  for (const CommandInnovation& s : command_innovation(flight)) sum += s / 3000.0;
  EXPECT_LT(sum.head<4>().cwiseAbs().maxCoeff(), 1e-9);
}

// every fifth command of the same flight was logged
FlightData with_slow_commands(FlightData flight) {
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  for (std::size_t k = 0; k < flight.commands.time_s().size(); k += 5) {
    time_s.push_back(flight.commands.time_s()[k]);
    speed.push_back(flight.commands.speed_radps()[k]);
  }
  flight.commands = CommandRecord(time_s, speed, false);
  return flight;
}

TEST(CommandInnovationOf, IsOneForAllSamplesOfASlowCommand) {
  const FlightData flight = with_slow_commands(flown(false));
  ASSERT_TRUE(commands_are_slower(flight));
  const std::vector<CommandInnovation> innovation = command_innovation(flight);
  for (std::size_t k = 100; k < 200; ++k) EXPECT_EQ(innovation[k][0] == innovation[k - 1][0], k % 5 != 0) << k;
}

TEST(CommandInnovationOf, HasRatesAndTorquesForWhatTheLoopDidBetweenSlowCommands) {
  const FlightData flight = with_slow_commands(flown(false));
  const std::vector<CommandInnovation> innovation = command_innovation(flight);
  EXPECT_EQ(innovation[123][8], flight.samples[123].body_rate_B_radps.x());
  EXPECT_NE(innovation[123][10], 0.0);
  EXPECT_EQ(rms(command_innovation(flown(false)), 8), 0.0);
}

TEST(CommandInnovationOf, TakesALogAtItsWordThatCommandsWereHeld) {
  FlightData flight = with_slow_commands(flown(false));
  flight.hold_known = true;
  EXPECT_FALSE(commands_are_slower(flight));
}

// an attitude at every fourth sample is known in between as it was, not as none
TEST(CommandInnovationOf, IsNotMadeByColumnsThatAreSlower) {
  FlightData whole = flown(true);
  for (std::size_t k = 0; k < whole.samples.size(); ++k) {
    whole.samples[k].position_W_m.x() = 50.0;
    whole.samples[k].channels |= has_position;
  }
  FlightData slow = whole;
  for (std::size_t k = 0; k < slow.samples.size(); ++k)
    if (k % 4 != 0) {
      slow.samples[k].channels &= ~has_position;
      slow.samples[k].position_W_m.setZero();
    }
  const std::vector<CommandInnovation> a = command_innovation(whole), b = command_innovation(slow);
  for (std::size_t k = 0; k < a.size(); ++k) ASSERT_NEAR(a[k][0], b[k][0], 1e-9) << k;
}

// what was logged before a gap predicts nothing behind it
TEST(CommandInnovationOf, BeginsAnewAfterAGap) {
  FlightData flight = flown(false);
  const std::vector<CommandInnovation> whole = command_innovation(flight);
  flight.samples[1500].starts_segment = true;
  const std::vector<CommandInnovation> parted = command_innovation(flight);
  EXPECT_NE(whole[1500][0], 0.0);
  EXPECT_NE(whole[1500][4], 0.0);
  EXPECT_EQ(parted[1500], CommandInnovation::Zero());
  EXPECT_NE(parted[1499][0], 0.0);
  EXPECT_NE(parted[1600][0], 0.0);
}

TEST(CommandInnovationOf, IsNotKnownWithoutTorques) {
  FlightData flight = flown(false);
  flight.collective_only = true;
  EXPECT_THAT(command_innovation(flight), IsEmpty());
}

}  // namespace command_innovation_test
}  // namespace gustlab::diagnosis
