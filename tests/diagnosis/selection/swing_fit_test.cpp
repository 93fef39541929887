// The fit of a swinging load on disturbances that a known load makes, and the error that it states against the scatter of many fits.
#include "diagnosis/selection/swing_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace swing_fit_test {

const VehicleModel vehicle = test::crazyflie();
const SwingingLoad truth{{0.32, 0.02}, 0.004, 0.006};

// 12 s of a vehicle that is pulled to and fro, each flight at another pace
FlightData pulled(double pace_radps) {
  return test::flight_of(
      vehicle, 12.0, 0.01,
      [=](double t) {
        Motion m;
        m.velocity_W_mps = Vector3(0.8 * std::sin(pace_radps * t), 0.5 * std::cos(0.6 * pace_radps * t), 0.0);
        m.acceleration_W_mps2 =
            pace_radps * Vector3(0.8 * std::cos(pace_radps * t), -0.3 * std::sin(0.6 * pace_radps * t), 0.0);
        return m;
      },
      [](double) { return test::all_at(vehicle.hover_speed_radps()); });
}

// what a filter that knew it would say of the disturbance, with white noise of this deviation in m/s²
Smoothed disturbed(const FlightData& flight, const SwingStart& start, double noise_mps2 = 0.0, std::uint64_t seed = 0) {
  const RandomStream random(seed, 0, "swing_fit_test");
  const std::vector<Vector3> force = swinging_force(flight, truth.swing, start);
  Smoothed s;
  s.disturbance.assign(force.size(), Eigen::Matrix<double, 6, 1>::Zero());
  for (std::size_t k = 0; k < force.size(); ++k) {
    const auto noise = random.normal4(k, 0);
    for (int axis = 0; axis < 2; ++axis)
      s.disturbance[k][axis] = (truth.mass_kg * force[k][axis] +
                                truth.drag_kgps * flight.motion[k].velocity_W_mps[axis] + start.trim_N[axis]) /
                                   vehicle.mass_kg +
                               noise_mps2 * noise[static_cast<std::size_t>(axis)];
  }
  return s;
}

const std::vector<SwingStart> true_starts = {{{0.3, -0.1}, {0.5, 0.2}, {0.001, -0.002}},
                                             {{-0.2, 0.25}, {0.0, -0.7}, {0.0, 0.003}}};

struct Flown {
  std::vector<FlightData> flights = {pulled(2.1), pulled(3.3)};
  std::vector<Smoothed> smoothed;
  std::vector<const FlightData*> flight_pointers;
  std::vector<const Smoothed*> smoothed_pointers;
  explicit Flown(double noise_mps2 = 0.0, std::uint64_t seed = 0) {
    for (std::size_t f = 0; f < 2; ++f) smoothed.push_back(disturbed(flights[f], true_starts[f], noise_mps2, seed + f));
    for (std::size_t f = 0; f < 2; ++f)
      flight_pointers.push_back(&flights[f]), smoothed_pointers.push_back(&smoothed[f]);
  }
  double fit(SwingingLoad& load, std::vector<SwingStart>& starts, bool load_free) const {
    return fit_swing(flight_pointers, smoothed_pointers, vehicle.mass_kg, load, starts, load_free);
  }
};

TEST(SwingFit, FindsTheLoadAndEveryFlightsStart) {
  const Flown flown;
  SwingingLoad load{{0.30, 0.03}, 0.003, 0.0};
  std::vector<SwingStart> starts(2);
  for (std::size_t f = 0; f < 2; ++f) starts[f].cable_W = 0.6 * true_starts[f].cable_W;
  EXPECT_LT(flown.fit(load, starts, true), 1e-9);
  EXPECT_NEAR(load.swing.length_m, truth.swing.length_m, 1e-4);
  EXPECT_NEAR(load.swing.damping, truth.swing.damping, 1e-3);
  EXPECT_NEAR(load.mass_kg, truth.mass_kg, 1e-5);
  EXPECT_NEAR(load.drag_kgps, truth.drag_kgps, 1e-4);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_LT((starts[f].cable_W - true_starts[f].cable_W).norm(), 2e-3) << f;
    EXPECT_LT((starts[f].rate_W_radps - true_starts[f].rate_W_radps).norm(), 2e-2) << f;
    EXPECT_LT((starts[f].trim_N - true_starts[f].trim_N).norm(), 1e-4) << f;
  }
}

TEST(SwingFit, MovesOnlyTheStartsWhenTheLoadIsGiven) {
  const Flown flown;
  SwingingLoad load = truth;
  std::vector<SwingStart> starts(2);
  EXPECT_LT(flown.fit(load, starts, false), 1e-9);
  EXPECT_NEAR(load.swing.length_m, truth.swing.length_m, 1e-15);
  EXPECT_NEAR(load.mass_kg, truth.mass_kg, 1e-15);
  for (std::size_t f = 0; f < 2; ++f) EXPECT_LT((starts[f].cable_W - true_starts[f].cable_W).norm(), 2e-3) << f;
}

TEST(SwingFit, ALengthOutOfAllBoundsHasNoCost) {
  const Flown flown;
  SwingingLoad load{{std::nan(""), 0.02}, 0.004, 0.0};
  std::vector<SwingStart> starts(2);
  EXPECT_FALSE(std::isfinite(flown.fit(load, starts, true)));
}

// it is twice that of independent means, and these are independent
TEST(SwingFit, StatesTwiceTheScatterOfFitsToWhiteNoise) {
  double squares = 0.0, stated = 0.0;
  constexpr int draws = 24;
  for (int draw = 0; draw < draws; ++draw) {
    const Flown flown(0.2, static_cast<std::uint64_t>(10 + 2 * draw));
    SwingingLoad load = truth;
    std::vector<SwingStart> starts = true_starts;
    flown.fit(load, starts, true);
    squares += std::pow(load.swing.length_m - truth.swing.length_m, 2);
    stated += load.swing.length_deviation_m / draws;
  }
  // of 24 draws a standard deviation is known to a seventh; two of these
  EXPECT_NEAR(stated / std::sqrt(squares / draws), 2.0, 2.0 * 2.0 / 7.0);
}

}  // namespace swing_fit_test
}  // namespace gustlab::diagnosis
