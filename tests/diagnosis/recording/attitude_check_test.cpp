#include "diagnosis/recording/attitude_check.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "gustlab/random.hpp"
#include "gustlab/types.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace attitude_check_test {

using ::testing::HasSubstr;

enum class Written { right, scalar_last, world_to_body };

// twenty seconds of a hover that leans by some mrad, partly against a gust that cancels it, and is pushed by something else
// as well, with `load` times the weight; a sample every 10 ms
FlightLog hover(double lean_rad, double push_mps2, double yaw_rad, Written written, double cancelled = 0.0,
                double load = 1.0) {
  const RandomStream stream(1, 0, "hover");
  FlightLog log;
  log.path = "somewhere/hover.csv";
  for (const char* name : {"vx", "vy", "qw", "qx", "qy", "qz"}) log.columns.push_back({name, {}});
  Vector3 velocity_W_mps = Vector3::Zero();
  for (std::size_t k = 0; k < 2000; ++k) {
    const double t = 0.01 * static_cast<double>(k);
    const Quaternion q = Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()) *
                         Eigen::AngleAxisd(lean_rad * std::sin(2.1 * t), Vector3::UnitY()) *
                         Eigen::AngleAxisd(lean_rad * std::sin(1.3 * t + 0.4), Vector3::UnitX());
    const auto noise = stream.normal4(k, 0);
    const Quaternion seen = written == Written::world_to_body ? q.conjugate() : q;
    const double right[] = {seen.w(), seen.x(), seen.y(), seen.z()}, last[] = {seen.x(), seen.y(), seen.z(), seen.w()};
    log.time_s.push_back(t);
    for (std::size_t i = 0; i < 2; ++i)
      log.columns[i].values.push_back(velocity_W_mps[static_cast<int>(i)] + 0.002 * noise[i]);
    for (std::size_t i = 0; i < 4; ++i)
      log.columns[2 + i].values.push_back((written == Written::scalar_last ? last : right)[i]);
    velocity_W_mps += 0.01 * ((1.0 - cancelled) * load * 9.81 * (q * Vector3::UnitZ()) +
                              push_mps2 * Vector3(std::sin(0.9 * t), std::cos(1.7 * t), 0.0));
  }
  return log;
}

TEST(AttitudeCheck, AHoverThatLeansAsItMovesIsFine) {
  for (const double yaw_rad : {0.0, 0.4, 2.5}) {
    EXPECT_TRUE(check_attitude(hover(0.02, 0.0, yaw_rad, Written::right), test::crazyflie()).empty());
    // what pushes is stronger than what leans
    EXPECT_TRUE(check_attitude(hover(0.02, 0.4, yaw_rad, Written::right), test::crazyflie()).empty());
    for (const Written written : {Written::right, Written::scalar_last})
      EXPECT_TRUE(check_attitude(hover(0.02, 0.05, yaw_rad, written, 0.9), test::crazyflie()).empty());
  }
}

TEST(AttitudeCheck, AnotherOrderOfTheQuaternionIsNamed) {
  for (const double yaw_rad : {0.0, 0.4, 2.5}) {
    const auto found = check_attitude(hover(0.02, 0.05, yaw_rad, Written::scalar_last), test::crazyflie());
    ASSERT_EQ(found.size(), 1u) << yaw_rad;
    EXPECT_EQ(found[0].file, "hover.csv");
    EXPECT_EQ(found[0].kind, "inconsistent");
    EXPECT_TRUE(found[0].sets_flight_aside);
    EXPECT_THAT(found[0].says, HasSubstr("were scalar-last: set aside"));
  }
  const auto found = check_attitude(hover(0.02, 0.05, 0.4, Written::world_to_body), test::crazyflie());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].says, HasSubstr("were world-to-body: set aside"));
}

TEST(AttitudeCheck, APathInOtherAxesThanTheAttitudeIsNamed) {
  for (const double yaw_rad : {0.0, 0.4, 2.5}) {
    FlightLog log = hover(0.02, 0.05, yaw_rad, Written::right);
    for (double& east : log.columns[1].values) east = -east;
    const auto found = check_attitude(log, test::crazyflie());
    ASSERT_EQ(found.size(), 1u) << yaw_rad;
    EXPECT_TRUE(found[0].sets_flight_aside);
    EXPECT_THAT(found[0].says, HasSubstr("as north-east-down has it: set aside"));
  }
}

// a vehicle that pulls 3 g accelerates three times as much as it leans at hover
TEST(AttitudeCheck, TheThrustThatIsCommandedIsWhatLeans) {
  const VehicleModel vehicle = test::crazyflie();
  FlightLog log = hover(0.02, 0.05, 0.4, Written::scalar_last, 0.0, 3.0);
  EXPECT_TRUE(check_attitude(log, vehicle).empty());
  log.meta.actuator = ActuatorKind::thrust;
  for (const char* name : {"u1", "u2", "u3", "u4"})
    log.columns.push_back({name, std::vector<double>(log.rows(), 3.0 * 9.81 * vehicle.mass_kg / 4.0)});
  const auto found = check_attitude(log, vehicle);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].says, HasSubstr("were scalar-last: set aside"));
}

// heading the other way, the inverse of an attitude leans nearly as the attitude does: what is left over tells them apart
TEST(AttitudeCheck, AReadingThatIsNearlyRightIsLeft) {
  const auto turned_by = [](double yaw_rad) {
    return check_attitude(hover(0.02, 0.0, yaw_rad, Written::world_to_body), test::crazyflie());
  };
  EXPECT_TRUE(turned_by(pi - 0.5).empty());
  EXPECT_FALSE(turned_by(pi - 0.9).empty());
}

TEST(AttitudeCheck, WhereNothingMovesNothingIsSaid) {
  for (const Written written : {Written::right, Written::scalar_last, Written::world_to_body})
    for (const double lean_rad : {0.001, 0.003})
      EXPECT_TRUE(check_attitude(hover(lean_rad, 0.0, 0.0, written), test::crazyflie()).empty());
  FlightLog blind = hover(0.02, 0.05, 0.0, Written::scalar_last);
  blind.columns.erase(blind.columns.begin());
  EXPECT_TRUE(check_attitude(blind, test::crazyflie()).empty());
}

}  // namespace attitude_check_test
}  // namespace gustlab::diagnosis
