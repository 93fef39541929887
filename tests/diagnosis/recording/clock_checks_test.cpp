// Two clocks in one recording: told where turning is quick enough to tell them, and not where it is slow.
#include "diagnosis/recording/clock_checks.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::IsEmpty;
using ::testing::Not;

constexpr double step_s = 0.01, duration_s = 25.0;

// roll rate of a recording: sines about a frequency
double roll_rate_radps(double time_s, double frequency_Hz) {
  return 0.6 * std::sin(2.0 * pi * frequency_Hz * time_s) + 0.4 * std::sin(2.0 * pi * 1.7 * frequency_Hz * time_s + 1.0);
}

// findings of a gyro that is `late_s` behind in the second half; rates from the attitude have an error that lasts a tenth of a second
std::vector<LogFinding> findings(double frequency_Hz, double late_s) {
  const RandomStream random(3, 0, "clock_checks_test");
  FlightData pose;
  pose.label = "a.csv";
  pose.sample_s = step_s;
  std::vector<Vector3> gyro;
  Vector3 error = Vector3::Zero();
  for (std::uint64_t k = 0; k * step_s < duration_s; ++k) {
    const double t = static_cast<double>(k) * step_s;
    const auto normal = random.normal4(k);
    for (int axis = 0; axis < 3; ++axis) error[axis] = 0.9 * error[axis] + 0.05 * normal[static_cast<std::size_t>(axis)];
    Sample sample;
    sample.time_s = t;
    pose.samples.push_back(sample);
    Motion motion;
    motion.body_rate_B_radps = error + roll_rate_radps(t, frequency_Hz) * Vector3::UnitX();
    pose.motion.push_back(motion);
    gyro.emplace_back(roll_rate_radps(t > 0.5 * duration_s ? t - late_s : t, frequency_Hz), 0.0, 0.0);
  }
  return rate_delays(pose, gyro);
}

TEST(ClockChecks, SeeAGyroThatFallsBehind) { EXPECT_THAT(findings(1.5, 0.08), Not(IsEmpty())); }

TEST(ClockChecks, SayNothingOfOneClock) { EXPECT_THAT(findings(1.5, 0.0), IsEmpty()); }

// the correlation of slow turning has a flat top, which wanders by tens of milliseconds
TEST(ClockChecks, SayNothingOfSlowTurning) { EXPECT_THAT(findings(0.25, 0.0), IsEmpty()); }

TEST(PoseGaps, AreLongerThanTheColumnsOwnIntervals) {
  std::vector<double> time_s, values;
  for (int k = 0; k < 400; ++k) {
    time_s.push_back(0.0025 * k);
    values.push_back(k % 4 == 0 && (k < 100 || k > 200) ? 1.0 : std::nan(""));
  }
  const auto gaps = pose_gaps(time_s, values);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_EQ(gaps.front(), (std::pair<std::size_t, std::size_t>{96, 204}));
}

}  // namespace
}  // namespace gustlab::diagnosis
