// Flights whose commands were held between samples, and flights whose commands went from one to the next in straight lines.
#include "diagnosis/alignment/hold.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gustlab/random.hpp"
#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace hold_test {

constexpr double step_s = 0.001, sample_s = 0.02, duration_s = 3.0;

class HoldOfCommands : public ::testing::TestWithParam<bool> {
 protected:
  RotorArray speeds(double t) const {
    RotorArray out{};
    for (std::size_t i = 0; i < 4; ++i)
      out[i] = vehicle.hover_speed_radps() *
               (1.0 + 0.01 * std::sin(25.0 * t + 1.7 * static_cast<double>(i)) + 0.02 * std::sin(60.0 * t));
    return out;
  }
  FlightLog flown(bool linear, double lag_s = 0.0) const {
    const CommandRecord commands =
        test::record_of([this](double t) { return speeds(t); }, duration_s, sample_s, linear);
    const RandomStream random(3, 0, "hold_test");
    std::vector<EffectSpec> effects = vehicle.effects;
    EffectSpec& lag = effects.emplace_back();
    lag.type = "motor_lag", lag.values = {{"time_constant", fmt::format("{}", lag_s)}};
    Plant plant(vehicle, make_effects(effects), {.step_s = step_s, .seed = 1, .replicate = 1});
    VehicleState state;
    state.position_W_m.z() = 1.0;
    state.rotor_speed_radps = speeds(0.0);
    plant.reset(state);
    FlightLog log;
    for (const char* name : {"px", "py", "pz", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "u1", "u2", "u3", "u4"})
      log.columns.push_back({name, {}});
    const int steps = static_cast<int>(std::lround(sample_s / step_s));
    for (std::uint64_t k = 0; static_cast<double>(k) * sample_s < duration_s; ++k) {
      const double t = static_cast<double>(k) * sample_s;
      const Observation seen = plant.observe(false);
      std::uint64_t c = 0;
      const auto put = [&](double value, double sd) {
        log.columns[c].values.push_back(value + sd * random.normal4(k, c)[0]), ++c;
      };
      log.time_s.push_back(t);
      for (int i = 0; i < 3; ++i) put(seen.position_W_m[i], 5e-4);
      put(seen.attitude_WB.w(), 0.0);
      for (int i = 0; i < 3; ++i) put(seen.attitude_WB.vec()[i], 5e-4);
      for (int i = 0; i < 3; ++i) put(seen.body_rate_B_radps[i], 5e-3);
      for (std::size_t i = 0; i < 4; ++i) put(speeds(t)[i], 0.0);
      for (int s = 0; s < steps; ++s) EXPECT_TRUE(plant.step({commands.mean(t + s * step_s, t + (s + 1) * step_s)}));
    }
    return log;
  }
  bool likelier(const FlightLog& log) const {
    return linear_is_likelier(vehicle, 1, [&](bool linear) {
      return std::vector<FlightData>{prepare_flight(log, vehicle, {.linear_hold = linear})};
    });
  }
  const VehicleModel vehicle = test::crazyflie();
};

TEST_P(HoldOfCommands, IsTheOneThatFlew) {
  const FlightLog log = flown(GetParam());
  EXPECT_EQ(likelier(log), GetParam());
}

// linearised at none the other one promises more
TEST_P(HoldOfCommands, IsTheOneThatFlewBesideALargeEffect) {
  const FlightLog log = flown(GetParam(), 0.09);
  EXPECT_EQ(likelier(log), GetParam());
}

INSTANTIATE_TEST_SUITE_P(BothWays, HoldOfCommands, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "linear" : "held"; });

}  // namespace hold_test
}  // namespace gustlab::diagnosis
