// Two clocks in one recording: found where the rotation is quick enough to show them, and not where it is slow.
#include "diagnosis/recording/clock_checks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace clock_checks_test {

constexpr double step_s = 0.01, duration_s = 25.0;

// roll rate of a recording: sines about a frequency
double roll_rate_radps(double time_s, double frequency_Hz) {
  return 0.6 * std::sin(2.0 * pi * frequency_Hz * time_s) +
         0.4 * std::sin(2.0 * pi * 1.7 * frequency_Hz * time_s + 1.0);
}

struct Flown {
  FlightData pose;
  FlightLog log;              // the gyro and an input that moves with it
  std::vector<Vector3> gyro;  // as the log has it
};

// A gyro that is late by some function of time; rates from the attitude have an error that lasts a tenth of a second.
Flown fly(double frequency_Hz, const std::function<double(double)>& latency_s) {
  const RandomStream random(3, 0, "clock_checks_test");
  Flown flown;
  flown.pose.label = "a.csv";
  flown.pose.sample_s = step_s;
  for (const char* name : {"wx", "wy", "wz", "u1"}) flown.log.columns.push_back({name, {}});
  Vector3 error = Vector3::Zero();
  for (std::uint64_t k = 0; k * step_s < duration_s; ++k) {
    const double t = static_cast<double>(k) * step_s;
    const auto normal = random.normal4(k);
    for (int axis = 0; axis < 3; ++axis)
      error[axis] = 0.9 * error[axis] + 0.05 * normal[static_cast<std::size_t>(axis)];
    Sample sample;
    sample.time_s = t;
    flown.pose.samples.push_back(sample);
    Motion motion;
    motion.body_rate_B_radps = error + roll_rate_radps(t, frequency_Hz) * Vector3::UnitX();
    flown.pose.motion.push_back(motion);
    flown.gyro.emplace_back(roll_rate_radps(t - latency_s(t), frequency_Hz), 0.0, 0.0);
    flown.log.time_s.push_back(t);
    for (std::size_t c = 0; c < 4; ++c)
      flown.log.columns[c].values.push_back(c == 1 || c == 2 ? 0.0 : flown.gyro.back().x());
  }
  return flown;
}

std::optional<ClockTrack> track(double frequency_Hz, double latency_s) {
  const Flown flown = fly(frequency_Hz, [&](double t) { return t > 0.5 * duration_s ? latency_s : 0.0; });
  return gyro_track(flown.pose, flown.gyro);
}

TEST(ClockChecks, SeeAGyroThatFallsBehind) { EXPECT_TRUE(track(1.5, 0.08)); }

TEST(ClockChecks, SayNothingOfOneClock) { EXPECT_FALSE(track(1.5, 0.0)); }

// the correlation of slow rotation has a flat top, which wanders by tens of milliseconds
TEST(ClockChecks, SayNothingOfSlowTurning) { EXPECT_FALSE(track(0.25, 0.0)); }

// it wanders by a few milliseconds a second, and jumps
TEST(ClockChecks, FollowAClockAndLayTheBoardOnThePose) {
  const auto latency_s = [](double t) { return (t > 9.0 ? 0.11 : 0.02) + 0.015 * std::sin(0.5 * t); };
  const Flown flown = fly(1.5, latency_s);
  const std::optional<ClockTrack> found = gyro_track(flown.pose, flown.gyro);
  ASSERT_TRUE(found);
  for (double t = 1.0; t < duration_s - 1.0; t += 0.25) {
    if (std::abs(t - 9.0) < 1.3) continue;  // the jump is inside a stretch
    EXPECT_NEAR(found->at(t), latency_s(t), 1.5 * step_s) << t;
  }
  const FlightLog laid = laid_on_pose_clock(flown.log, *found);
  std::vector<Vector3> gyro;
  for (const double w : *laid.find("wx")) gyro.emplace_back(w, 0.0, 0.0);
  EXPECT_FALSE(gyro_track(flown.pose, gyro));
  // all that is on board moves with it
  for (std::size_t k = 200; k < 800; ++k) EXPECT_NEAR((*laid.find("u1"))[k], roll_rate_radps(laid.time_s[k], 1.5), 0.1);
}

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

}  // namespace clock_checks_test
}  // namespace gustlab::diagnosis
