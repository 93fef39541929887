// The air between fans, closed forms where there is no turbulence.
#include <gtest/gtest.h>

#include "effects/effects.hpp"
#include "gustlab/random.hpp"
#include "support/parameters.hpp"
#include "support/vehicles.hpp"

namespace gustlab::test {
namespace fans_test {

std::unique_ptr<Effect> fans(std::int64_t count, double turbulence) {
  auto effect = make_fans();
  set(*effect, "count", count);
  set_number(*effect, "center_speed_mps", 1.2);
  set_number(*effect, "edge_speed_mps", 2.0);
  set_number(*effect, "turbulence", turbulence);
  effect->prepare(crazyflie(), 0.002, RandomStream(1, 1, "fans"));
  return effect;
}

Vector3 wind_at(const Effect& effect, const Vector3& position_W_m, double time_s = 0.0) {
  Flow flow;
  flow.time_s = time_s;
  flow.position_W_m = position_W_m;
  RotorSet rotors;
  effect.on_rotor(flow, rotors);
  return -flow.air_velocity_B_mps;
}

TEST(Fans, BlowTowardTheCentreAndFasterAtTheEdge) {
  const auto one = fans(1, 0.0);
  EXPECT_NEAR((wind_at(*one, Vector3::Zero()) - Vector3(-1.2, 0.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((wind_at(*one, {1.0, 0.0, 0.0}) - Vector3(-2.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
  // one half width off the axis; behind the fan nothing moves
  EXPECT_NEAR(wind_at(*one, {0.0, 0.5, 0.0}).x(), -1.2 * std::exp(-1.0), 1e-12);
  EXPECT_EQ(wind_at(*one, {2.5, 0.0, 0.0}).norm(), 0.0);
}

TEST(Fans, FacingEachOtherCancelInTheMeanAtTheCentre) {
  EXPECT_NEAR(wind_at(*fans(4, 0.0), Vector3::Zero()).norm(), 0.0, 1e-12);
}

TEST(Fans, TurbulenceHasTheVarianceThatWasAskedFor) {
  const auto one = fans(1, 0.5);
  Vector3 sum = Vector3::Zero(), squares = Vector3::Zero();
  constexpr int samples = 40000;
  for (int k = 0; k < samples; ++k) {
    const Vector3 off = wind_at(*one, Vector3::Zero(), 0.05 * k) - Vector3(-1.2, 0.0, 0.0);
    sum += off;
    squares += off.cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(sum[axis] / samples, 0.0, 0.05);
    EXPECT_NEAR(std::sqrt(squares[axis] / samples), 0.6, 0.06);
  }
}

}  // namespace fans_test
}  // namespace gustlab::test
