#include "control/rotors.hpp"

#include <gtest/gtest.h>

#include "support/vehicles.hpp"

namespace gustlab {
namespace rotors_test {

std::vector<VehicleModel> vehicles() {
  std::vector<VehicleModel> all{test::crazyflie(), test::iris()};
  for (int count = 3; count <= 8; ++count) all.push_back(test::ring(count, 1.0, 0.2, 0.02));
  return all;
}

TEST(Mixer, GivesTheWrenchThatIsAskedForWithinItsLimits) {
  for (const VehicleModel& vehicle : vehicles()) {
    const Mixer mixer(vehicle);
    Vector3 torque = 0.2 * mixer.torque_authority_B_Nm();
    if (vehicle.rotor_count == 3) torque.z() = 0.0;
    const RotorCommand command = mixer.speeds(vehicle.weight_N(), torque);
    EXPECT_NEAR(mixer.force_B_N(command.speed_radps).z(), vehicle.weight_N(), 1e-9 * vehicle.weight_N())
        << vehicle.name;
    EXPECT_LT((mixer.torque_B_Nm(command.speed_radps) - torque).norm(), 1e-9 * vehicle.weight_N() * vehicle.arm_m())
        << vehicle.name;
  }
}

TEST(Mixer, NothingInNothingOut) {
  for (const VehicleModel& vehicle : vehicles())
    for (const double speed : Mixer(vehicle).speeds(0.0, Vector3::Zero()).speed_radps) EXPECT_EQ(speed, 0.0);
}

TEST(Mixer, GivenTooMuchKeepsRollAndPitchAndItsLimits) {
  for (const VehicleModel& vehicle : vehicles()) {
    const Mixer mixer(vehicle);
    // far more yaw than there is, and a thrust at the limit
    const Vector3 tilt(0.3 * mixer.torque_authority_B_Nm().x(), -0.3 * mixer.torque_authority_B_Nm().y(), 0.0);
    const RotorCommand command =
        mixer.speeds(mixer.max_thrust_N(), tilt + Vector3(0.0, 0.0, 100.0 * mixer.torque_authority_B_Nm().z()));
    const Vector3 torque = mixer.torque_B_Nm(command.speed_radps);
    EXPECT_LT((torque - tilt).head<2>().norm(), 1e-6 * vehicle.weight_N() * vehicle.arm_m()) << vehicle.name;
    for (int i = 0; i < vehicle.rotor_count; ++i) {
      EXPECT_LE(command.speed_radps[static_cast<std::size_t>(i)], vehicle.max_speed_radps * (1.0 + 1e-12));
      EXPECT_GE(command.speed_radps[static_cast<std::size_t>(i)], 0.0);
    }
    // torques beyond reach keep their direction
    const Vector3 wild = 1e3 * Vector3(mixer.torque_authority_B_Nm().x(), 0.0, 0.0);
    const Vector3 got = mixer.torque_B_Nm(mixer.speeds(vehicle.weight_N(), wild).speed_radps);
    EXPECT_GT(got.x(), mixer.torque_authority_B_Nm().x() * 0.9) << vehicle.name;
  }
}

TEST(Mixer, LetsANanThrough) {
  const Mixer mixer(test::iris());
  const double nan = std::nan("");
  for (const RotorCommand& command :
       {mixer.speeds(nan, Vector3::Zero()), mixer.speeds(10.0, {nan, 0.0, 0.0}), mixer.speeds(10.0, {0.0, 0.0, nan})})
    EXPECT_TRUE(std::isnan(command.speed_radps[0]));
}

TEST(PwmMap, GoesThereAndBackForEveryForm) {
  VehicleModel line = test::crazyflie();
  VehicleModel polynomial = line;
  polynomial.actuator.pwm_line.reset();
  polynomial.actuator.pwm_thrust = {0.001, 5e-7, 2.5e-11};
  VehicleModel straight = polynomial;
  straight.actuator.pwm_thrust = {0.0, 2e-6, 0.0};
  VehicleModel none = line;
  none.actuator.pwm_line.reset();
  for (const VehicleModel& vehicle : {line, polynomial, straight, none}) {
    const PwmMap map(vehicle);
    for (const double pwm : {10000.0, 38781.0, 65535.0}) {
      const double speed = map.speed_of_pwm(pwm);
      EXPECT_NEAR(map.pwm_of_thrust(vehicle.rotors[0].thrust_coefficient_Ns2 * speed * speed), pwm, 1e-6);
    }
  }
}

TEST(PwmMap, HoversAtCrazySimsPwm) {
  const VehicleModel vehicle = test::crazyflie();
  EXPECT_NEAR(PwmMap(vehicle).pwm_of_thrust(vehicle.hover_thrust_N()), 38781.0, 10.0);
}

TEST(NominalMotorLag, IsThatOfTheVehicleFile) {
  EXPECT_EQ(nominal_motor_lag_s(test::crazyflie()), 0.0125);
  EXPECT_EQ(nominal_motor_lag_s(test::iris()), 0.0);
}

}  // namespace rotors_test
}  // namespace gustlab
