// Residuals of the specific force alone: what they weigh, and the moments that EM learns from, by hand.
#include "diagnosis/estimation/direct_forces.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/linear_flights.hpp"

namespace gustlab::diagnosis {
namespace direct_forces_test {

constexpr double interval_s = 0.02;
const std::vector<Vector3> residuals = {{1.0, 2.0, -1.0}, {0.5, -1.0, 3.0}, {-2.0, 0.0, 1.0}, {4.0, 1.0, 0.0}};

// of a vehicle that is turned by a right angle about z: its x axis points along y of the world
LinearFlight flight_of_residuals() {
  LinearFlight flight;
  const Matrix3 turned = (Matrix3() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0).finished();
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    Vector12 y = Vector12::Zero();
    y.tail<3>() = residuals[k];
    Eigen::Matrix<bool, row_count, 1> measured = Eigen::Matrix<bool, row_count, 1>::Constant(false);
    measured.tail<3>().setConstant(true);
    flight.y.push_back(y), flight.measured.push_back(measured), flight.felt_by.emplace_back(Vector3(0.1, 0.2, 0.3)),
        flight.R_WB.push_back(turned);
    flight.b.push_back(Vector12::Zero()), flight.interval_s.push_back(interval_s), flight.starts.push_back(k == 0);
  }
  flight.columns = {7};
  return flight;
}

FlightData sampled() {
  FlightData data;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    Sample sample;
    sample.time_s = interval_s * static_cast<double>(k);
    data.samples.push_back(sample);
  }
  return data;
}

// a mean over a long time of a process (σ², τ) has the variance 2 σ² τ / time: so has that of white noise of variance 2 σ² τ / Δt
TEST(DirectForces, CountAsWhiteNoiseOfTheSameStrengthAtLowFrequency) {
  NoiseModel noise = test::some_noise();
  noise.variance = {0.04, 0.09, 1.0, 1.0};
  noise.time_s = {0.2, 0.005, 1.0, 1.0};
  const Whitened w = whiten_forces(sampled(), flight_of_residuals(), noise);
  ASSERT_EQ(w.rows.rows(), 12);
  ASSERT_EQ(w.rows.cols(), 2);
  // across: 2 · 0.2 s / 0.02 s = 20 samples long; along the thrust shorter than a sample, so each counts in full
  const double across = std::sqrt(0.04 * 20.0), along = 0.3;
  double misfit = 0.0;
  for (Eigen::Index k = 0; k < 4; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      const double sd = axis < 2 ? across : along, y = residuals[static_cast<std::size_t>(k)][axis];
      EXPECT_NEAR(w.rows(3 * k + axis, 0), 0.1 * (axis + 1) / sd, 1e-12);
      EXPECT_NEAR(w.rows(3 * k + axis, 1), y / sd, 1e-12);
      EXPECT_EQ(w.channel[static_cast<std::size_t>(3 * k + axis)], 9 + axis);
      EXPECT_EQ(w.time_s[static_cast<std::size_t>(3 * k + axis)], interval_s * static_cast<double>(k));
      misfit += 2.0 * std::log(sd) + y * y / (sd * sd);
    }
  EXPECT_NEAR(w.minus_two_log_likelihood, misfit, 1e-9);
}

TEST(DirectForces, FurtherColumnsAreFeltInTheBody) {
  // a push along x of the world and one that only turns
  SpatialAccelerations push = SpatialAccelerations::Zero(6, 2);
  push(0, 0) = 5.0, push(3, 1) = 5.0;
  const FurtherColumns further = {2, [&](std::size_t) -> const SpatialAccelerations& { return push; }};
  NoiseModel noise = test::some_noise();
  const Whitened with = whiten_forces(sampled(), flight_of_residuals(), noise, further),
                 without = whiten_forces(sampled(), flight_of_residuals(), noise);
  ASSERT_EQ(with.rows.cols(), 4);
  EXPECT_NEAR(with.minus_two_log_likelihood, without.minus_two_log_likelihood, 1e-12);
  // the world's x is the body's −y here
  const double sd = residuals[0].y() / without.rows(1, 1);
  EXPECT_NEAR(with.rows(0, 1), 0.0, 1e-12);
  EXPECT_NEAR(with.rows(1, 1), -5.0 / sd, 1e-12);
  EXPECT_NEAR(with.rows.col(2).norm(), 0.0, 1e-12);
  EXPECT_EQ(with.rows.col(3), without.rows.col(1));
}

TEST(DirectForces, RowsThatWereNotMeasuredAreLeftOut) {
  LinearFlight flight = flight_of_residuals();
  flight.measured[1][10] = false;
  const Whitened w = whiten_forces(sampled(), flight, test::some_noise());
  ASSERT_EQ(w.rows.rows(), 11);
  EXPECT_EQ(w.channel[3], 9);
  EXPECT_EQ(w.channel[4], 11);
}

TEST(DirectForces, MomentsAreOfNeighboursInOnePiece) {
  const Smoothed s = smooth_forces(flight_of_residuals());
  const std::array<double, 3> second = {1.0 + 0.25 + 4.0 + 16.0, 4.0 + 1.0 + 0.0 + 1.0, 1.0 + 9.0 + 1.0 + 0.0};
  const std::array<double, 3> lagged = {0.5 - 1.0 - 8.0, -2.0 + 0.0 + 0.0, -3.0 + 3.0 + 0.0};
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(s.second[j], second[j], 1e-12);
    EXPECT_NEAR(s.lagged[j], lagged[j], 1e-12);
    EXPECT_EQ(s.count[j], 4.0);
    EXPECT_EQ(s.pairs[j], 3.0);
  }
  // in the world: the body's x is the world's y
  EXPECT_NEAR(s.disturbance[0][0], -2.0, 1e-12);
  EXPECT_NEAR(s.disturbance[0][1], 1.0, 1e-12);
  EXPECT_NEAR(s.disturbance[0][2], -1.0, 1e-12);

  LinearFlight gap = flight_of_residuals();
  gap.starts[2] = true;
  const Smoothed pieces = smooth_forces(gap);
  EXPECT_NEAR(pieces.lagged[0], 0.5 - 8.0, 1e-12);
  EXPECT_EQ(pieces.pairs[0], 2.0);
  LinearFlight hole = flight_of_residuals();
  hole.measured[1][9] = false;
  const Smoothed missing = smooth_forces(hole);
  EXPECT_EQ(missing.count[0], 3.0);
  EXPECT_NEAR(missing.lagged[0], -8.0, 1e-12);
}

}  // namespace direct_forces_test
}  // namespace gustlab::diagnosis
