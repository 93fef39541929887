// Rotors behind the lead follow as rotors of a shorter lag would.
#include "control/rotor_lead.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/vehicles.hpp"

namespace gustlab {
namespace rotor_lead_test {

constexpr double period_s = 0.002;

TEST(RotorLead, LeavesQuickRotorsAlone) {
  for (const double lag_s : {0.0, 0.015}) {
    RotorLead lead(test::ring(4, 1.5, 0.25, lag_s), period_s);
    EXPECT_EQ(lead.lag_s(), lag_s);
    lead.reset({});
    RotorCommand wanted;
    wanted.speed_radps.fill(500.0);
    EXPECT_EQ(lead.update(wanted).speed_radps, wanted.speed_radps);
  }
}

// the true rotor, exact over each period, is where the lead's model is: each period it closes 4 (1 − e^(−T/τ)) of the gap
TEST(RotorLead, SlowRotorsFollowFourTimesAsFast) {
  constexpr double lag_s = 0.1, from = 480.0, to = 520.0;
  RotorLead lead(test::ring(4, 1.5, 0.25, lag_s), period_s);
  EXPECT_NEAR(lead.lag_s(), lag_s / 4.0, 1e-12);
  RotorArray speed;
  speed.fill(from);
  lead.reset(speed);
  RotorCommand wanted;
  wanted.speed_radps.fill(to);
  const double follows = 1.0 - std::exp(-period_s / lag_s);
  for (int k = 1; k <= 50; ++k) {
    const RotorCommand command = lead.update(wanted);
    for (std::size_t i = 0; i < 4; ++i) speed[i] += follows * (command.speed_radps[i] - speed[i]);
    EXPECT_NEAR(speed[2], to + (from - to) * std::pow(1.0 - 4.0 * follows, k), 1e-9) << k;
  }
  // in a quarter of the lag nearly as far as without the lead in all of it
  EXPECT_NEAR(to + (from - to) * std::pow(1.0 - 4.0 * follows, 12.5), to + (from - to) * std::exp(-1.0), 0.5);
}

TEST(RotorLead, AsksForNoMoreThanTheLimit) {
  VehicleModel vehicle = test::ring(4, 1.5, 0.25, 0.05);
  vehicle.max_speed_radps = 800.0;
  RotorLead lead(vehicle, period_s);
  RotorArray speed;
  speed.fill(700.0);
  lead.reset(speed);
  RotorCommand wanted;
  wanted.speed_radps = {799.0, 100.0, 700.0, 750.0};
  const RotorCommand command = lead.update(wanted);
  EXPECT_EQ(command.speed_radps[0], 800.0);
  EXPECT_EQ(command.speed_radps[1], 0.0);
  EXPECT_EQ(command.speed_radps[2], 700.0);
}

}  // namespace rotor_lead_test
}  // namespace gustlab
