// A vehicle that turns as its rotors have it, and files that say something else of them.
#include "diagnosis/recording/vehicle_check.hpp"

#include <gmock/gmock.h>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace vehicle_check_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double sample_s = 0.01, average_s = 0.09;

VehicleModel truth() { return test::iris(); }

// every rotor has sines of its own
RotorArray speeds(double t) {
  RotorArray out{};
  for (std::size_t i = 0; i < 4; ++i) {
    const double n = static_cast<double>(i);
    out[i] = truth().hover_speed_radps() *
             (1.0 + 0.03 * std::sin((9.0 + 2.3 * n) * t + n) + 0.02 * std::sin((17.0 - 1.7 * n) * t + 2.0 * n));
  }
  return out;
}

// the torque of its rotors, some time later, over as long as an angular acceleration is fitted
FlightData turning(double delay_s = 0.0, const std::function<RotorArray(double)>& commanded = speeds) {
  const VehicleModel vehicle = truth();
  FlightData flight = test::flight_of(
      vehicle, 12.0, sample_s, [](double) { return Motion{}; }, commanded);
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const double t = flight.samples[k].time_s - delay_s;
    const RotorArray mean = flight.commands.mean(t - 0.5 * average_s, t + 0.5 * average_s);
    Vector3 torque = Vector3::Zero();
    for (std::size_t i = 0; i < 4; ++i) {
      const Rotor& r = vehicle.rotors[i];
      torque += r.thrust_coefficient_Ns2 * mean[i] * mean[i] *
                (r.position_B_m.cross(r.axis_B) - r.direction * r.torque_ratio_m * r.axis_B);
    }
    flight.motion[k].angular_acceleration_B_radps2 = vehicle.inertia_B_kgm2.inverse() * torque;
  }
  return flight;
}

TEST(CheckRotors, SaysNothingOfAFileThatIsRight) {
  VehicleModel vehicle = truth();
  EXPECT_THAT(check_rotors({turning()}, vehicle), IsEmpty());
}

TEST(CheckRotors, FindsTheOrderThatTurnsTheVehicleAsItTurned) {
  // what u1 to u4 drive by the file: two across exchanged, front and back, the two in front, the two on one side
  for (const std::array<std::size_t, 4>& place :
       {std::array<std::size_t, 4>{1, 0, 2, 3}, {0, 1, 3, 2}, {3, 2, 1, 0}, {2, 1, 0, 3}, {3, 1, 2, 0}}) {
    VehicleModel vehicle = truth();
    vehicle.source_path = "somewhere/iris.toml";
    for (std::size_t i = 0; i < 4; ++i) vehicle.rotors[i] = truth().rotors[place[i]];
    const auto findings = check_rotors({turning()}, vehicle);
    ASSERT_EQ(findings.size(), 1u) << place[0];
    EXPECT_EQ(findings[0].kind, "inconsistent");
    EXPECT_EQ(findings[0].file, "iris.toml");
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(vehicle.rotors[i].position_B_m, truth().rotors[i].position_B_m) << i;
      EXPECT_EQ(vehicle.rotors[i].direction, truth().rotors[i].direction) << i;
    }
  }
}

// a loop answers with a torque of another size; a wrong moment of inertia in the file is within
TEST(CheckRotors, TakesNoOrderWhoseTorquesAreOfAnotherSize) {
  for (const double size : {0.27, 0.45, 2.2, 4.0}) {
    VehicleModel vehicle = truth();
    std::swap(vehicle.rotors[0], vehicle.rotors[3]);
    FlightData flight = turning();
    for (Motion& motion : flight.motion) motion.angular_acceleration_B_radps2 *= size;
    EXPECT_EQ(check_rotors({flight}, vehicle).size(), size > 0.4 && size < 2.5 ? 1u : 0u) << size;
  }
}

TEST(CheckRotors, FindsThatAllTurnTheOtherWayRound) {
  VehicleModel vehicle = truth();
  for (Rotor& rotor : vehicle.rotors) rotor.direction *= -1.0;
  const auto findings = check_rotors({turning()}, vehicle);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, "sign");
  EXPECT_THAT(findings[0].says, HasSubstr("every rotor turns the other way"));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(vehicle.rotors[i].direction, truth().rotors[i].direction) << i;
}

// of what the speeds explain of such a yaw nearly all is against the torque of the file
TEST(CheckRotors, LeavesDirectionsAloneWhereTheRotorsHardlyExplainYaw) {
  VehicleModel vehicle = truth();
  FlightData flight = turning();
  const RandomStream random(6, 0, "vehicle_check_test");
  for (std::size_t k = 0; k < flight.motion.size(); ++k) {
    double& yaw = flight.motion[k].angular_acceleration_B_radps2.z();
    yaw = -yaw + 0.1 * random.normal4(k)[2];
  }
  EXPECT_THAT(check_rotors({flight}, vehicle), IsEmpty());
  EXPECT_EQ(vehicle.rotors[0].direction, truth().rotors[0].direction);
}

// what yaws a right vehicle comes from elsewhere, and its loop answers at once with a torque that is far too small, or takes nearly all back
TEST(CheckRotors, LeavesDirectionsAloneWhereYawIsOfAnotherSize) {
  for (const double size : {-6.0, -0.1}) {
    VehicleModel vehicle = truth();
    FlightData flight = turning();
    for (Motion& motion : flight.motion) motion.angular_acceleration_B_radps2.z() *= size;
    EXPECT_THAT(check_rotors({flight}, vehicle), IsEmpty()) << size;
    EXPECT_EQ(vehicle.rotors[0].direction, truth().rotors[0].direction);
  }
}

// at 4 Hz half a swing is an eighth of a second
TEST(CheckRotors, TakesTheLesserOfTwoDelaysThatExplainAsMuch) {
  VehicleModel vehicle = truth();
  FlightData flight = turning(0.125, [](double t) {
    RotorArray out{};
    for (std::size_t i = 0; i < 4; ++i) {
      const double n = static_cast<double>(i);
      out[i] = truth().hover_speed_radps() * (1.0 + 0.03 * std::sin((24.0 + 0.6 * n) * t + n));
    }
    return out;
  });
  for (Motion& motion : flight.motion) motion.angular_acceleration_B_radps2 *= -1.0;
  EXPECT_THAT(check_rotors({flight}, vehicle), IsEmpty());
  EXPECT_EQ(vehicle.rotors[0].position_B_m, truth().rotors[0].position_B_m);
}

// the body answers its rotors at once; more of how it turns is what they did an eighth of a second ago, the other way round
TEST(CheckRotors, LeavesTheFileAloneThatAgreesBefore) {
  VehicleModel vehicle = truth();
  FlightData flight = turning(0.125);
  const FlightData at_once = turning();
  for (std::size_t k = 0; k < flight.motion.size(); ++k) {
    Vector3& turn = flight.motion[k].angular_acceleration_B_radps2;
    turn = 0.6 * at_once.motion[k].angular_acceleration_B_radps2 - turn;
  }
  EXPECT_THAT(check_rotors({flight}, vehicle), IsEmpty());
  EXPECT_EQ(vehicle.rotors[0].position_B_m, truth().rotors[0].position_B_m);
}

// a flight that tells nothing changes nothing
TEST(CheckRotors, LeavesTheFileAloneWhereTurningTellsNothing) {
  VehicleModel vehicle = truth();
  std::swap(vehicle.rotors[0], vehicle.rotors[1]);
  FlightData noise = turning();
  const RandomStream random(6, 0, "vehicle_check_test");
  for (std::size_t k = 0; k < noise.motion.size(); ++k) {
    const auto n = random.normal4(k);
    noise.motion[k].angular_acceleration_B_radps2 = {n[0], n[1], n[2]};
  }
  EXPECT_THAT(check_rotors({noise}, vehicle), IsEmpty());
  FlightData collective = turning();
  collective.collective_only = true;
  EXPECT_THAT(check_rotors({collective}, vehicle), IsEmpty());
  EXPECT_EQ(vehicle.rotors[0].position_B_m, truth().rotors[1].position_B_m);
}

TEST(TorqueDelay, IsThatOfTheTurningBehindTheRotors) {
  for (const double delay_s : {-0.02, 0.0, 0.013, 0.06}) {
    const auto found = torque_delay_s(turning(delay_s), truth());
    ASSERT_TRUE(found) << delay_s;
    EXPECT_NEAR(*found, delay_s, 1e-3);
  }
  FlightData reversed = turning();
  for (Motion& motion : reversed.motion) motion.angular_acceleration_B_radps2.setZero();
  EXPECT_FALSE(torque_delay_s(reversed, truth()));
}

// iris: both are changes over six samples of the same mean; per hub's lever and (Ω/Ω_h)²
TEST(AngularAccelerationSeries, OfTorqueAndOfAccelerationAreProportional) {
  const AngularAccelerationSeries series = angular_acceleration_series(turning(), truth());
  const VehicleModel vehicle = truth();
  const double force_N = vehicle.rotors[0].thrust_coefficient_Ns2 * std::pow(vehicle.hover_speed_radps(), 2);
  ASSERT_EQ(series.torque.size(), 1201u);
  EXPECT_TRUE(std::isnan(series.torque.front().x()) && std::isnan(series.acceleration.back().y()));
  double size = 0.0;
  for (std::size_t k = 20; k < 1180; ++k) {
    const Eigen::Vector2d expected =
        force_N * series.torque[k].cwiseQuotient(vehicle.inertia_B_kgm2.diagonal().head<2>());
    EXPECT_LT((series.acceleration[k] - expected).norm(), 1e-6) << k;
    size = std::max(size, expected.norm());
  }
  EXPECT_GT(size, 1.0);
}

}  // namespace vehicle_check_test
}  // namespace gustlab::diagnosis
