// The sum of the rotors' thrusts as the only command.
#include "diagnosis/recording/total_thrust.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace gustlab::diagnosis {
namespace {

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

}  // namespace
}  // namespace gustlab::diagnosis
