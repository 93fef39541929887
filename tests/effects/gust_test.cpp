// The gust's moments, spectrum, schedule, limits and clock against closed forms.
#include <gmock/gmock.h>

#include <cmath>
#include <complex>
#include <numeric>

#include "support/effects.hpp"

namespace gustlab::test {
namespace gust_test {

// the force in W (or the torque) at every step; the vehicle stands level
std::vector<Vector3> record(const Values& values, double duration_s, double step_s, std::uint64_t seed = 3,
                            std::uint32_t replicate = 1, bool torque = false) {
  const NamedEffect gust = make_effect("gust", values);
  const VehicleModel vehicle = small_quadrotor();
  gust.effect->prepare(vehicle, step_s, RandomStream(seed, replicate, "gust"));
  std::vector<double> state(static_cast<std::size_t>(gust.effect->state_size()));
  gust.effect->reset_state(state);
  std::vector<Vector3> result;
  for (int k = 0; k < std::lround(duration_s / step_s); ++k) {
    Wrench wrench;
    gust.effect->wrench(Flow{}, RotorSet{}, state, wrench);
    result.push_back(torque ? wrench.torque_B_Nm : wrench.force_B_N);
    gust.effect->advance(Flow{}, RotorSet{}, wrench, step_s, state);
  }
  return result;
}

double mean_product(const std::vector<Vector3>& force, int axis, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t k = lag; k < force.size(); ++k) sum += force[k][axis] * force[k - lag][axis];
  return sum / static_cast<double>(force.size() - lag);
}

TEST(Gust, HasTheMomentsOfItsEulerMaruyamaProcess) {
  constexpr double sigma = 0.04, tau = 0.5, tick = 0.02, duration = 20000.0;
  const auto force = record({{"sigma_xy", sigma}, {"sigma_z", 0.01}, {"correlation_time", tau}}, duration, tick);
  // x⁺ = (1 − a) x + σ√dt ξ, a = dt/τ: variance sigma² / (1 − a/2), autocorrelation (1 − a)^lag
  const double a = tick / tau;
  // relative standard error of a variance over T: √(2 τ / T)
  const double tolerance = 5 * std::sqrt(2 * tau / duration);
  for (int axis = 0; axis < 2; ++axis) {
    const double variance = mean_product(force, axis, 0);
    EXPECT_NEAR(variance / (sigma * sigma / (1 - a / 2)), 1.0, tolerance);
    for (const std::size_t lag : {1, 10, 25, 50})
      EXPECT_NEAR(mean_product(force, axis, lag) / variance, std::pow(1 - a, static_cast<double>(lag)), tolerance);
  }
  EXPECT_NEAR(std::sqrt(mean_product(force, 2, 0)) / 0.01, 1.0, tolerance);
  double cross = 0.0;
  for (const Vector3& f : force) cross += f.x() * f.y() / static_cast<double>(force.size());
  EXPECT_NEAR(cross / (sigma * sigma), 0.0, tolerance);
}

TEST(Gust, HasTheSpectrumOfItsProcessAndALine) {
  constexpr double sigma = 0.04, tau = 0.5, tick = 0.02, amplitude = 0.05;
  constexpr int window = 5000, windows = 200;  // 100 s each
  const double line = 2 * pi * 0.5;
  const auto force =
      record({{"sigma_xy", sigma}, {"correlation_time", tau}, {"line_amplitude", amplitude}, {"line_frequency", line}},
             window * windows * tick, tick);
  const auto power = [&](double frequency_Hz) {
    double sum = 0.0;
    for (int w = 0; w < windows; ++w) {
      std::complex<double> transform = 0.0;
      for (int k = 0; k < window; ++k)
        transform +=
            force[static_cast<std::size_t>(w * window + k)].x() * std::polar(1.0, -2 * pi * frequency_Hz * k * tick);
      sum += std::norm(transform) / window / windows;
    }
    return sum;
  };
  const double a = tick / tau;
  for (const double f : {0.1, 0.3, 1.0, 3.0, 10.0}) {
    // |1 − (1 − a) e^{−iωdt}|⁻² times the variance of one increment
    const double expected = 2 * sigma * sigma * a / std::norm(1.0 - (1 - a) * std::polar(1.0, -2 * pi * f * tick));
    EXPECT_NEAR(power(f) / expected, 1.0, 5 / std::sqrt(windows)) << f;
  }
  // a sinusoid of amplitude A gives A²/4 per sample at its own frequency
  EXPECT_NEAR(power(0.5) / (amplitude * amplitude / 4 * window), 1.0, 0.1);
}

TEST(Gust, SinusoidHasItsPhaseAndStopsInPauses) {
  const auto force = record(
      {{"line_amplitude", 0.05}, {"line_frequency", 2.0}, {"phase", 0.7}, {"on_s", 3.0}, {"off_s", 2.0}}, 20.0, 0.02);
  for (std::size_t k = 0; k < force.size(); ++k) {
    const double t = 0.02 * static_cast<double>(k);
    const bool on = k % 250 < 150;
    EXPECT_NEAR(force[k].x(), on ? 0.05 * std::sin(2.0 * t) : 0.0, 1e-12) << k;
    EXPECT_NEAR(force[k].y(), on ? 0.05 * std::sin(2.0 * t + 0.7) : 0.0, 1e-12) << k;
    EXPECT_EQ(force[k].z(), 0.0);
  }
}

TEST(Gust, DecaysToItsMeanInPauses) {
  const Values values = {{"sigma_xy", 0.04}, {"correlation_time", 0.5}, {"on_s", 3.0},     {"off_s", 2.0},
                         {"mean_x", 0.01},   {"drift_x", 0.02},         {"drift_y", -0.01}};
  const auto force = record(values, 5.0, 0.02);
  // the first value without noise is that of tick 150; from there the gap shrinks by 1 − dt/τ
  const Vector3 rest(0.03, -0.01, 0.0), gap = force[150] - rest;
  ASSERT_GT(gap.norm(), 1e-3);
  for (std::size_t k = 150; k < 250; ++k)
    EXPECT_LT((force[k] - rest - gap * std::pow(1 - 0.04, static_cast<double>(k - 150))).norm(), 1e-12) << k;
}

TEST(Gust, IsLimitedInSizeThenInRate) {
  Values values = {{"sigma_xy", 0.1}, {"correlation_time", 0.3}, {"limit_N", 0.08}};
  const auto clamped = record(values, 60.0, 0.02);
  values["rate_limit_Nps"] = 0.5;
  const auto slow = record(values, 60.0, 0.02);
  int at_limit = 0, at_rate = 0;
  Vector3 before = Vector3::Zero();
  for (std::size_t k = 0; k < slow.size(); ++k) {
    EXPECT_LE(clamped[k].norm(), 0.08 * (1 + 1e-12));
    at_limit += clamped[k].norm() > 0.08 * (1 - 1e-12);
    // follows the clamped force as fast as it may
    const double wanted = (clamped[k] - before).norm(), moved = (slow[k] - before).norm();
    EXPECT_NEAR(moved, std::min(wanted, 0.5 * 0.02), 1e-12) << k;
    at_rate += wanted > 0.5 * 0.02;
    before = slow[k];
  }
  EXPECT_GT(at_limit, 100);
  EXPECT_GT(at_rate, 100);
}

TEST(Gust, HasItsOwnClock) {
  const Values values = {{"sigma_xy", 0.04}, {"line_amplitude", 0.02}, {"on_s", 0.6}, {"off_s", 0.3}};
  const auto coarse = record(values, 10.0, 0.02), fine = record(values, 10.0, 0.002),
             odd = record(values, 10.0, 0.0025);
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    EXPECT_EQ(coarse[k], fine[10 * k]) << k;
    EXPECT_EQ(coarse[k], fine[10 * k + 9]) << k;
    EXPECT_EQ(coarse[k], odd[8 * k]) << k;
  }
}

TEST(Gust, SlowPlantSkipsNoTick) {
  const Values values = {{"sigma_xy", 0.04}, {"rate_Hz", 200.0}};
  const auto fine = record(values, 10.0, 0.005), coarse = record(values, 10.0, 0.02);
  for (std::size_t k = 0; k < coarse.size(); ++k) EXPECT_EQ(coarse[k], fine[4 * k]) << k;
}

TEST(Gust, RandomPhaseShiftsScheduleAndLineByRun) {
  Values values = {{"line_amplitude", 0.05}, {"line_frequency", 1.0}, {"on_s", 1.0}, {"off_s", 3.0}};
  const auto on_share = [](const std::vector<Vector3>& force) {
    return static_cast<double>(
               std::count_if(force.begin(), force.end(), [](const Vector3& f) { return f.norm() > 0.0; })) /
           static_cast<double>(force.size());
  };
  EXPECT_EQ(record(values, 8.0, 0.02, 3, 1), record(values, 8.0, 0.02, 3, 2));
  values["random_phase"] = 1.0;
  const auto one = record(values, 400.0, 0.02, 3, 1), two = record(values, 400.0, 0.02, 3, 2);
  EXPECT_NE(one, two);
  EXPECT_NEAR(on_share(one), 0.25, 0.01);
  EXPECT_NEAR(on_share(two), 0.25, 0.01);
}

TEST(Gust, AxesHaveTheirOwnStrength) {
  const auto force = record({{"sigma_xy", 0.04},
                             {"sigma_factor.y", 0.0},
                             {"line_amplitude", 0.05},
                             {"line_factor.x", 0.0},
                             {"line_factor.z", 2.0},
                             {"line_factor.y", 0.0}},
                            10.0, 0.02);
  const auto alike = record({{"sigma_xy", 0.04}}, 10.0, 0.02);
  for (std::size_t k = 0; k < force.size(); ++k) {
    EXPECT_EQ(force[k].x(), alike[k].x());
    EXPECT_EQ(force[k].y(), 0.0);
    EXPECT_NEAR(force[k].z(), 0.1 * std::sin(0.02 * static_cast<double>(k)), 1e-12);
  }
}

TEST(Gust, TorqueIsASecondProcessWithItsOwnLimits) {
  const Values values = {{"torque_sigma_xy", 1e-4}, {"torque_sigma_z", 5e-5}, {"correlation_time", 0.5}};
  const auto torque = record(values, 20000.0, 0.02, 3, 1, true);
  const double tolerance = 5 * std::sqrt(2 * 0.5 / 20000.0) + 0.02;  // and dt/τ/2 of Euler–Maruyama
  EXPECT_NEAR(std::sqrt(mean_product(torque, 0, 0)) / 1e-4, 1.0, tolerance);
  EXPECT_NEAR(std::sqrt(mean_product(torque, 2, 0)) / 5e-5, 1.0, tolerance);
  const auto force = record(values, 10.0, 0.02);
  EXPECT_EQ(force, std::vector<Vector3>(force.size(), Vector3::Zero()));
  Values limited = values;
  limited["torque_limit_Nm"] = 1.5e-4;
  limited["torque_rate_limit_Nmps"] = 1e-3;
  Vector3 before = Vector3::Zero();
  for (const Vector3& t : record(limited, 60.0, 0.02, 3, 1, true)) {
    EXPECT_LE(t.norm(), 1.5e-4 * (1 + 1e-12));
    EXPECT_LE((t - before).norm(), 1e-3 * 0.02 * (1 + 1e-12));
    before = t;
  }
}

const Values bursts{{"sigma_xy", 0.04},
                    {"correlation_time", 0.5},
                    {"line_amplitude", 0.02},
                    {"line_frequency", 3.0},
                    {"mean_x", 0.01},
                    {"drift_y", 0.005},
                    {"on_s", 2.0},
                    {"off_s", 1.0},
                    {"limit_N", 0.05},
                    {"rate_limit_Nps", 0.3},
                    {"torque_sigma_xy", 1e-5}};

// GIVEN a gust of twice the strength WHEN it blows THEN every force and torque is twice as large, its limits too
TEST(Gust, StrengthMultipliesAllOfIt) {
  for (const bool torque : {false, true}) {
    Values doubled = bursts;
    doubled["strength"] = 2.0;
    const auto once = record(bursts, 10.0, 0.002, 3, 1, torque), twice = record(doubled, 10.0, 0.002, 3, 1, torque);
    for (std::size_t k = 0; k < once.size(); ++k) EXPECT_LT((twice[k] - 2.0 * once[k]).norm(), 1e-15);
  }
  Values none = bursts;
  none["strength"] = 0.0;
  for (const Vector3& force : record(none, 5.0, 0.002)) EXPECT_EQ(force, Vector3::Zero());
}

}  // namespace gust_test
}  // namespace gustlab::test
