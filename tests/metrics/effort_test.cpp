#include "metrics/effort.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace gustlab {
namespace effort_test {

// a sine of amplitude A and ω has the standard deviation A/√2 and its rate Aω/√2; a rotor that stands still halves the mean square
TEST(Effort, IsThatOfASine) {
  constexpr double amplitude = 50.0, omega = 2.0 * pi, interval = 0.002;
  Effort effort(1.0, interval);
  for (int k = 0; k < 5500; ++k) {
    const double time = interval * k, sine = time < 1.0 ? 1e6 : amplitude * std::sin(omega * time);
    effort.add(time, std::array{2000.0 + sine, 1900.0});
  }
  EXPECT_NEAR(effort.figures().speed_sd_radps, amplitude / 2.0, 0.01);
  EXPECT_NEAR(effort.figures().acceleration_radps2, amplitude * omega / 2.0, 0.1);
  EXPECT_TRUE(std::isnan(Effort(0.0, interval).figures().speed_sd_radps));
}

}  // namespace effort_test
}  // namespace gustlab
