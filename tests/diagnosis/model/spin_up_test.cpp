// Where a flight begins, or goes on after a gap, nobody knows how fast its motors turn; what follows does not depend on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/model/propagation.hpp"
#include "simulation/make_effects.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace spin_up_test {

// samples every 10 ms and commands every 2 ms that swing, but for a gap from 1 to 2.005 s
FlightData flight(double first_radps) {
  FlightData data;
  data.vehicle = test::crazyflie();
  data.sample_s = 0.01, data.substeps = 5;
  std::vector<double> at_s;
  std::vector<RotorArray> speed;
  for (int k = 0; k < 1500; ++k) {
    const double t = 0.002 * k;
    if (t >= 1.0 && t < 2.005) continue;
    at_s.push_back(t);
    RotorArray row{};
    row.fill(k == 0 ? first_radps : 1900.0 + 100.0 * std::sin(8.0 * t));
    speed.push_back(row);
  }
  data.commands = CommandRecord(at_s, speed, false);
  for (int k = 0; k < 300; ++k) data.samples.push_back({.time_s = 0.01 * k});
  data.samples.front().starts_segment = true;
  data.motion.resize(data.samples.size());
  return data;
}

RotorHistory speeds(const FlightData& data) {
  ForceModel forces(data.vehicle, make_effects(data.vehicle.effects));
  forces.prepare(0.002, 0, 0);
  return commanded_history(data, forces);
}

TEST(SpinUp, IsLeftOutAtTheStartAndAfterAGapInTheCommands) {
  const FlightData rest = without_spin_up(flight(1900.0));
  EXPECT_EQ(rest.samples.size(), 300u - 15u - 15u);
  EXPECT_EQ(rest.motion.size(), rest.samples.size());
  EXPECT_NEAR(rest.samples.front().time_s, 0.15, 1e-9);
  EXPECT_TRUE(rest.samples.front().starts_segment);
  const auto after =
      std::find_if(rest.samples.begin(), rest.samples.end(), [](const Sample& s) { return s.time_s > 2.005; });
  ASSERT_NE(after, rest.samples.end());
  EXPECT_NEAR(after->time_s, 2.16, 1e-9);
  EXPECT_TRUE(after->starts_segment);
  EXPECT_EQ(std::ranges::count_if(rest.samples, &Sample::starts_segment), 2);
}

// the first of the flight's commands is off by 500 rad/s, and motors remember it for 12.5 to 25 ms
TEST(SpinUp, OfWhatIsLeftEarlierCommandsSaySpeeds) {
  const FlightData whole = flight(1900.0), kicked = flight(2400.0);
  const RotorHistory expected = speeds(whole), found = speeds(without_spin_up(kicked));
  EXPECT_GT(speeds(kicked).at_sample[1][0] - expected.at_sample[1][0], 100.0);
  for (std::size_t k = 0; k < 80; ++k) EXPECT_NEAR(found.at_sample[k][0], expected.at_sample[k + 15][0], 1.5) << k;
}

// measured speeds are known from the first
TEST(SpinUp, OfMeasuredSpeedsThereIsNone) {
  FlightData data = flight(1900.0);
  data.measured_speed = data.commands;
  EXPECT_EQ(without_spin_up(data).samples.size(), data.samples.size());
}

}  // namespace spin_up_test
}  // namespace gustlab::diagnosis
