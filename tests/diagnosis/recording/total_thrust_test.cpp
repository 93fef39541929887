// The sum of the rotors' thrusts as the only command.
#include "diagnosis/recording/total_thrust.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace total_thrust_test {

// or thrust would be nought in four of five rows of a log whose commands are slow
TEST(TotalThrust, IsMissingWhereCommandsAre) {
  VehicleModel vehicle;
  vehicle.rotor_count = 4;
  for (int i = 0; i < 4; ++i) vehicle.rotors[static_cast<std::size_t>(i)].thrust_coefficient_Ns2 = 1e-5;
  vehicle.actuator.throttle_thrust = {0.0, 2.0, 3.0};
  FlightLog log;
  log.meta.actuator = ActuatorKind::throttle;
  log.time_s = {0.0, 0.1, 0.2};
  for (const char* name : {"u1", "u2", "u3", "u4"}) log.columns.push_back({name, {0.5, std::nan(""), 0.0}});
  const FlightLog total = with_total_thrust(log, vehicle);
  ASSERT_EQ(total.columns.size(), 1u);
  EXPECT_NEAR(total.columns[0].values[0], 4.0 * (1.0 + 0.75), 1e-12);
  EXPECT_TRUE(std::isnan(total.columns[0].values[1]));
  EXPECT_EQ(total.columns[0].values[2], 0.0);
}

constexpr double step_s = 1e-4;

// the equation of the lag, in small steps: 12.5 ms up, 25 ms down
double risen_or_fallen(double speed_radps, double command_radps) {
  return speed_radps + step_s * (command_radps - speed_radps) / (command_radps > speed_radps ? 0.0125 : 0.025);
}

// Commands that jitter by 120 rad/s about 1,900 every 10 ms: motors do not come down as fast as they went up, so that what they push is more than
// was commanded. The sum jitters by half as much, and motors that obeyed it would gain less.
TEST(TotalThrust, HasWhatMotorsThatRiseFasterThanTheyFallMakeOfJitter) {
  const VehicleModel vehicle = test::crazyflie();
  ASSERT_FALSE(vehicle.effects.empty());
  std::mt19937 random(1);
  std::normal_distribution<double> jitter_radps(0.0, 120.0);
  FlightLog log;
  log.meta.actuator = ActuatorKind::rotor_speed;
  for (const char* name : {"u1", "u2", "u3", "u4"}) log.columns.push_back({name, {}});
  constexpr int rows = 2000, steps = 100;
  const double per_N = vehicle.rotors[0].thrust_coefficient_Ns2;
  double commanded_N = 0.0, made_N = 0.0;
  RotorArray speed{};
  speed.fill(1900.0);
  for (int k = 0; k < rows; ++k) {
    log.time_s.push_back(0.01 * k);
    for (std::size_t i = 0; i < 4; ++i) {
      const double command = 1900.0 + jitter_radps(random);
      log.columns[i].values.push_back(command);
      commanded_N += per_N * command * command / rows;
      for (int s = 0; s < steps; ++s) {
        speed[i] = risen_or_fallen(speed[i], command);
        made_N += per_N * speed[i] * speed[i] / (rows * steps);
      }
    }
  }
  const FlightLog total = with_total_thrust(log, vehicle);
  double of_sum_N = 0.0, one = 1900.0;
  for (const double total_N : total.columns[0].values)
    for (int s = 0; s < steps; ++s) {
      one = risen_or_fallen(one, std::sqrt(total_N / (4.0 * per_N)));
      of_sum_N += 4.0 * per_N * one * one / (rows * steps);
    }
  EXPECT_GT(made_N, 1.025 * commanded_N);
  EXPECT_NEAR(of_sum_N, made_N, 0.002 * made_N);
}

}  // namespace total_thrust_test
}  // namespace gustlab::diagnosis
