// The Crazyflie's mixer against the four lines of the firmware's power_distribution_quadrotor.
#include "control/legacy_mixer.hpp"

#include <gtest/gtest.h>

#include "support/vehicles.hpp"

namespace gustlab {
namespace legacy_mixer_test {

// m1 front right, m2 back right, m3 back left, m4 front left; the firmware's pitch is nose up, ours nose down. m1 and m3 turn
// counterclockwise (direction +1): yaw to the left slows them
std::array<double, 4> firmware_pwm(double thrust, double roll, double pitch, double yaw) {
  const double r = roll / 2.0, p = -pitch / 2.0;
  return {thrust - r + p - yaw, thrust - r - p + yaw, thrust + r - p - yaw, thrust + r + p + yaw};
}

double speed(double pwm) { return 0.04076521 * pwm + 380.8359; }

TEST(LegacyMixer, IsTheFirmwaresOnTheCrazyflie) {
  const LegacyMixer mixer(test::crazyflie());
  const auto pwm = firmware_pwm(36000.0, 1200.0, -700.0, 300.0);
  const RotorCommand command = mixer.speeds(36000.0, {1200.0, -700.0, 300.0});
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(command.speed_radps[i], speed(pwm[i]), 1e-6) << i;
}

TEST(LegacyMixer, TakesWhatIsAboveTheScaleFromAllAndCutsWhatIsBelow) {
  const LegacyMixer mixer(test::crazyflie());
  auto pwm = firmware_pwm(60000.0, 20000.0, 0.0, 0.0);
  RotorCommand command = mixer.speeds(60000.0, {20000.0, 0.0, 0.0});
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(command.speed_radps[i], speed(pwm[i] - (70000.0 - 65535.0)), 1e-6);
  pwm = firmware_pwm(5000.0, 20000.0, 0.0, 0.0);
  command = mixer.speeds(5000.0, {20000.0, 0.0, 0.0});
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(command.speed_radps[i],
                LegacyMixer(test::crazyflie()).speeds(std::max(pwm[i], 0.0), {0, 0, 0}).speed_radps[i], 1e-6);
}

TEST(LegacyMixer, ThrustOfACountIsThatOfItsSpeeds) {
  const VehicleModel vehicle = test::crazyflie();
  const LegacyMixer mixer(vehicle);
  for (const double pwm : {10000.0, 36000.0, 60000.0}) {
    double thrust_N = 0.0;
    const RotorCommand command = mixer.speeds(pwm, Vector3::Zero());
    for (std::size_t i = 0; i < 4; ++i)
      thrust_N += vehicle.rotors[i].thrust_coefficient_Ns2 * command.speed_radps[i] * command.speed_radps[i];
    EXPECT_NEAR(mixer.total_thrust_of_pwm(pwm), thrust_N, 1e-12);
    EXPECT_NEAR(mixer.pwm_of_total_thrust(thrust_N), pwm, 1e-6 * pwm);
  }
}

}  // namespace legacy_mixer_test
}  // namespace gustlab
