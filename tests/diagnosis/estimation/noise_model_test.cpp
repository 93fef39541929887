// The EM step on statistics whose answer is known, and Aitken's extrapolation on geometric series.
#include "diagnosis/estimation/noise_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/estimation/innovation_filter.hpp"
#include "support/linear_flights.hpp"

namespace gustlab::diagnosis {
namespace noise_model_test {

constexpr double sample_s = 0.01;

NoiseModel some_noise() {
  NoiseModel noise = test::some_noise();
  noise.least_white = {1e-6, 1e-6, 1e-6, 1e-6};
  return noise;
}

// what a flight of so many samples, in parts between gaps, would have on average, were the disturbance of this model
Smoothed expected_of(const NoiseModel& noise, double count, double parts = 1.0) {
  Smoothed s;
  const auto set = [&](std::size_t j, double variance, double time_s) {
    s.count[j] = count, s.pairs[j] = count - parts;
    s.second[j] = count * variance;
    s.earlier[j] = s.later[j] = (count - parts) * variance;
    s.lagged[j] = (count - parts) * variance * std::exp(-sample_s / time_s);
  };
  for (std::size_t j = 0; j < 6; ++j) {
    const auto g = static_cast<std::size_t>(disturbance_group[j]);
    set(j, noise.variance[g], noise.time_s[g]);
    s.white[j] = (count - parts) * noise.white[g];
  }
  for (std::size_t r = 0; r < row_count; ++r)
    if (noise.errors_last()) set(6 + r, noise.lasting_variance[r / 3], noise.lasting_time_s[r / 3]);
  for (std::size_t g = 0; g < noise_groups; ++g)
    s.residual[g] = 3.0 * count * noise.measurement[g], s.residual_count[g] = 3.0 * count;
  return s;
}

void expect_alike(const NoiseModel& a, const NoiseModel& b) {
  for (std::size_t g = 0; g < 4; ++g) {
    EXPECT_NEAR(a.variance[g], b.variance[g], 1e-12 * b.variance[g]) << g;
    EXPECT_NEAR(a.time_s[g], b.time_s[g], 1e-9 * b.time_s[g]) << g;
    EXPECT_NEAR(a.white[g], b.white[g], 1e-12 * b.white[g]) << g;
    EXPECT_NEAR(a.measurement[g], b.measurement[g], 1e-12 * b.measurement[g]) << g;
    EXPECT_NEAR(a.lasting_variance[g], b.lasting_variance[g], 1e-12 * b.lasting_variance[g]) << g;
    EXPECT_NEAR(a.lasting_time_s[g], b.lasting_time_s[g], 1e-9 * b.lasting_time_s[g]) << g;
  }
}

TEST(NoiseUpdate, FindsTheModelThatTheStatisticsAreOf) {
  NoiseModel truth = some_noise(), start = some_noise();
  start.variance = {1.0, 1.0, 1.0, 1.0};
  start.time_s = {0.5, 0.5, 0.5, 0.5};
  start.measurement = {1.0, 1.0, 1.0, 1.0};
  // flights of unequal length count by their samples
  expect_alike(update(start, {expected_of(truth, 100.0), expected_of(truth, 900.0)}, sample_s), truth);
  truth.lasting_variance = {1e-5, 2e-5, 3e-4, 0.1};
  truth.lasting_time_s = {0.02, 0.05, 0.1, 0.3};
  start.lasting_variance = {1.0, 1.0, 1.0, 1.0};
  start.lasting_time_s = {0.2, 0.2, 0.2, 0.2};
  expect_alike(update(start, {expected_of(truth, 100.0), expected_of(truth, 900.0)}, sample_s), truth);
}

TEST(NoiseUpdate, WeighsFlightsByWhatTheySaw) {
  NoiseModel quiet = some_noise(), loud = some_noise();
  for (double& v : loud.variance) v *= 5.0;
  for (double& v : loud.measurement) v *= 3.0;
  const NoiseModel next = update(quiet, {expected_of(quiet, 300.0, 3.0), expected_of(loud, 100.0)}, sample_s);
  for (std::size_t g = 0; g < 4; ++g) {
    EXPECT_NEAR(next.variance[g], 2.0 * quiet.variance[g], 1e-12);
    EXPECT_NEAR(next.measurement[g], 1.5 * quiet.measurement[g], 1e-12);
  }
}

TEST(NoiseUpdate, StaysWithinItsBounds) {
  NoiseModel still = some_noise();
  still.white = {0.0, 0.0, 0.0, 0.0};
  still.time_s = {50.0, 50.0, 1e-4, 1e-4};
  still.measurement = {0.0, 0.0, 0.0, 0.0};
  NoiseModel start = some_noise();
  const NoiseModel next = update(start, {expected_of(still, 200.0)}, sample_s);
  EXPECT_EQ(next.white, start.least_white);
  EXPECT_EQ(next.time_s[0], slowest_disturbance_s);
  // no white part takes what is quick
  EXPECT_LT(next.time_s[2], 0.04);
  EXPECT_GE(next.time_s[2], 0.002);
  for (const double v : next.measurement) EXPECT_GT(v, 0.0);
  EXPECT_TRUE(next.possible());
  still.white = {1e-3, 1e-3, 1e-3, 1e-3};
  EXPECT_EQ(update(start, {expected_of(still, 200.0)}, sample_s).time_s[2], 0.04);
}

// What nothing explains yet may last (a load's weight). A process that must forget sooner moves by less than its mean square says.
TEST(NoiseUpdate, AConstantIsNotTakenForChance) {
  constexpr double constant = 3.0, count = 5000.0;
  Smoothed flight = expected_of(some_noise(), count);
  flight.second[2] += count * constant * constant;
  for (auto* sum : {&flight.earlier, &flight.later, &flight.lagged}) (*sum)[2] += (count - 1.0) * constant * constant;
  const NoiseModel next = update(some_noise(), {flight}, sample_s);
  EXPECT_EQ(next.time_s[1], slowest_disturbance_s);
  const double a = std::exp(-sample_s / slowest_disturbance_s),
               steps = flight.later[2] - 2.0 * a * flight.lagged[2] + a * a * flight.earlier[2];
  const auto unlikely = [&](double variance) {
    return count * std::log(variance) + (flight.second[2] - flight.later[2] + steps / (1.0 - a * a)) / variance;
  };
  EXPECT_LT(unlikely(next.variance[1]), unlikely(1.01 * next.variance[1]));
  EXPECT_LT(unlikely(next.variance[1]), unlikely(next.variance[1] / 1.01));
  EXPECT_LT(unlikely(next.variance[1]), unlikely(constant * constant) - 1000.0);
}

// hovers under a steady downward push that the model lacks, which rocks a little
LinearFlight pushed_flight() {
  constexpr std::size_t samples = 2000;
  LinearFlight flight;
  Matrix12 F = Matrix12::Identity();
  for (int i = 0; i < 3; ++i) F(i, 3 + i) = F(6 + i, 9 + i) = sample_s;
  for (std::size_t k = 0; k < samples; ++k) {
    flight.F.push_back(F);
    flight.b.push_back(Vector12::Zero());
    flight.b.back()[5] = -sample_s * (2.6 + 0.5 * std::sin(0.11 * static_cast<double>(k)));
    flight.interval_s.push_back(sample_s);
    flight.starts.push_back(k == 0);
    flight.measured.push_back(Eigen::Matrix<bool, row_count, 1>::Constant(true));
    flight.measured.back().tail<3>().setConstant(false);
    flight.y.push_back(Vector12::Zero());
    for (int row = 0; row < 9; ++row)
      flight.y.back()[row] = 1e-3 * std::sin(1.0 + static_cast<double>(row + 1) * static_cast<double>(k * k));
    flight.R_WB.push_back(Matrix3::Identity());
    flight.force_rows.push_back(Eigen::Matrix<double, 3, 9>::Zero());
  }
  return flight;
}

TEST(NoiseUpdate, MakesTheFlightLikelierEveryTime) {
  const LinearFlight flight = pushed_flight();
  NoiseModel noise = some_noise();
  double unlikely = misfit(flight, noise);
  bool at_bound = false;
  for (int step = 0; step < 40; ++step) {
    noise = update(noise, {smooth(flight, noise)}, sample_s);
    const double now = misfit(flight, noise);
    EXPECT_LT(now, unlikely + 1e-9 * std::abs(unlikely)) << step;
    unlikely = now;
    at_bound |= noise.time_s[1] == slowest_disturbance_s;
  }
  EXPECT_TRUE(at_bound);
}

TEST(NoiseUpdate, LeavesAloneWhatNobodySaw) {
  const NoiseModel start = some_noise();
  expect_alike(update(start, {Smoothed{}}, sample_s), start);
}

TEST(NoiseModel, ImpossibleWhereTooSlowOrTooQuiet) {
  EXPECT_TRUE(some_noise().possible());
  NoiseModel slow = some_noise();
  slow.time_s[3] = 1.01 * slowest_disturbance_s;
  EXPECT_FALSE(slow.possible());
  NoiseModel lasting = some_noise();
  lasting.lasting_time_s[1] = 1.01 * slowest_disturbance_s;
  EXPECT_FALSE(lasting.possible());
  NoiseModel quiet = some_noise();
  quiet.white[2] = 0.5 * quiet.least_white[2];
  EXPECT_FALSE(quiet.possible());
}

// an Ornstein-Uhlenbeck process has the power 2 v T at low frequency, white acceleration its own
TEST(NoiseModel, SizeIsOfBothParts) {
  NoiseModel noise = some_noise();
  EXPECT_NEAR(noise.rms(0), std::sqrt(0.04 + 1e-4 / 0.02), 1e-12);
  EXPECT_NEAR(noise.rms(3), std::sqrt(0.7 + 4e-3 / 0.008), 1e-12);
  noise.lasting_time_s.fill(0.1);
  EXPECT_NEAR(std::pow(noise.rms(0), 2) * 2.0 * calm_memory_s, 2.0 * 0.04 * 0.2 + 1e-4, 1e-12);
  EXPECT_NEAR(noise.rms(3), std::sqrt(0.7 + 4e-3 / 0.008), 1e-12);
}

TEST(NoiseModel, LargestChangeIsOfAnyLogarithm) {
  const NoiseModel from = some_noise();
  EXPECT_EQ(largest_change(from, from), 0.0);
  NoiseModel to = from;
  to.variance[1] *= 1.1;
  to.measurement[3] /= 1.5;
  EXPECT_NEAR(largest_change(from, to), std::log(1.5), 1e-12);
  to.time_s[0] *= 2.0;
  EXPECT_NEAR(largest_change(from, to), std::log(2.0), 1e-12);
  to.white[2] *= 3.0;
  EXPECT_NEAR(largest_change(from, to), std::log(3.0), 1e-12);
  // of what is not there yet there is no logarithm
  to.lasting_variance[0] = 1.0;
  EXPECT_NEAR(largest_change(from, to), std::log(3.0), 1e-12);
}

// logarithms that go a share of the way each time
NoiseModel on_the_way(const NoiseModel& from, const NoiseModel& to, double rate, int steps) {
  NoiseModel at = to;
  const double left = std::pow(rate, steps);
  const auto move = [&](const auto& a, const auto& b, auto& out) {
    for (std::size_t g = 0; g < a.size(); ++g) out[g] = b[g] * std::pow(a[g] / b[g], left);
  };
  move(from.variance, to.variance, at.variance);
  move(from.time_s, to.time_s, at.time_s);
  move(from.white, to.white, at.white);
  move(from.measurement, to.measurement, at.measurement);
  return at;
}

TEST(NoiseExtrapolation, FindsTheLimitOfAGeometricSeries) {
  const NoiseModel to = some_noise();
  NoiseModel from = to;
  from.variance = {0.05, 0.08, 0.6, 0.6};
  from.time_s = {0.25, 0.2, 0.12, 0.06};
  from.white = {2e-4, 1e-4, 2e-3, 5e-3};
  from.measurement = {2e-6, 1e-5, 4e-4, 0.02};
  expect_alike(extrapolated(on_the_way(from, to, 0.7, 0), on_the_way(from, to, 0.7, 1), on_the_way(from, to, 0.7, 2)),
               to);
}

TEST(NoiseExtrapolation, GoesNoFartherThanItMay) {
  const NoiseModel last = some_noise();
  // not a series that ends: the same factor again
  NoiseModel first = last, second = last;
  first.variance[0] = last.variance[0] / 4.0, second.variance[0] = last.variance[0] / 2.0;
  first.time_s[1] = last.time_s[1] / 9.0, second.time_s[1] = last.time_s[1] / 3.0;
  first.white[0] = last.white[0] * 1e4, second.white[0] = last.white[0] * 1e2;
  // to and fro
  first.measurement[0] = last.measurement[0] * 1.1, second.measurement[0] = last.measurement[0] * 2.0;
  second.measurement[1] = last.measurement[1] * 2.0;
  NoiseModel floored = last;
  floored.least_white[0] = 0.9 * last.white[0];
  const NoiseModel next = extrapolated(first, second, floored);
  EXPECT_NEAR(next.variance[0], last.variance[0] * std::exp(1.5), 1e-12);
  EXPECT_EQ(next.time_s[1], slowest_disturbance_s);
  EXPECT_EQ(next.white[0], floored.least_white[0]);
  EXPECT_EQ(next.measurement[1], last.measurement[1]);
  EXPECT_EQ(next.variance[3], last.variance[3]);
}

}  // namespace noise_model_test
}  // namespace gustlab::diagnosis
