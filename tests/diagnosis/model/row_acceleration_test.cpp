// What rotors leave of how a body turns from row to row.
#include "diagnosis/model/row_acceleration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace row_acceleration_test {

constexpr double sample_s = 0.01, duration_s = 10.0;
constexpr std::size_t roll = 0, pitch = 1;

// A body that turns at 2 sin 5t rad/s in roll, and at nothing but noise in pitch; the rotors explain the roll, twice as much as there is.
std::array<AccelerationLeft, 2> left(double noise_radps, double kept) {
  const RandomStream random(3, 0, "gyro");
  const FlightData flight = test::flight_of(
      test::crazyflie(), duration_s, sample_s,
      [&](double t) {
        Motion motion;
        const auto noise = random.normal4(static_cast<std::uint64_t>(std::lround(t / sample_s)));
        motion.body_rate_B_radps =
            Vector3(2.0 * std::sin(5.0 * t), 0.0, 0.0) + noise_radps * Vector3(noise[0], noise[1], 0.0);
        return motion;
      },
      [](double) { return test::all_at(2000.0); });
  std::vector<Eigen::Vector4d> rotors;
  for (const Sample& sample : flight.samples) {
    const double change = 2.0 * (std::sin(5.0 * (sample.time_s + sample_s)) - std::sin(5.0 * sample.time_s));
    rotors.emplace_back(2.0 * change / sample_s, std::cos(7.0 * sample.time_s), 0.0, 0.0);
  }
  return acceleration_left({flight}, {rotors}, kept);
}

TEST(RowAcceleration, IsWhatRotorsExplainWhateverTheirGain) {
  EXPECT_NEAR(left(0.0, 0.0)[roll].share, 0.0, 1e-9);
  EXPECT_NEAR(left(0.01, 0.0)[pitch].share, 1.0, 0.01);
}

TEST(RowAcceleration, KeptFromRowToRowHidesLessBehindTheGyroscopesNoise) {
  EXPECT_GT(left(0.05, 0.0)[roll].share, 0.3);
  EXPECT_LT(left(0.05, 0.9)[roll].share, 0.05);
}

TEST(RowAcceleration, CountsRowsThatAreIndependent) {
  const double rows = duration_s / sample_s;
  EXPECT_NEAR(left(0.05, 0.0)[pitch].rows, rows, 0.01 * rows);
  EXPECT_LT(left(0.0, 0.9)[roll].rows, 0.2 * rows);
}

}  // namespace row_acceleration_test
}  // namespace gustlab::diagnosis
