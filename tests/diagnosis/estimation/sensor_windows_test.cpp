// Sensors against each other: what is wrong with one of them is found without any model of the vehicle.
#include "diagnosis/estimation/sensor_windows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "diagnosis/estimation/gram.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"
#include "util/rotations.hpp"

namespace gustlab::diagnosis {
namespace sensor_windows_test {

constexpr double sample_s = 0.004, duration_s = 20.0;

// a vehicle that swings about all axes and wanders, with exact rates by differences
Motion swinging(double t) {
  const auto attitude = [](double at) {
    return turned(
        turned(Quaternion::Identity(), Vector3(0.3 * std::sin(2.0 * at), 0.2 * std::sin(1.3 * at + 1.0), 0.0)),
        Vector3(0.0, 0.0, 0.5 * std::sin(0.9 * at)));
  };
  const auto position = [](double at) {
    return Vector3(std::sin(at), std::cos(0.7 * at), 1.0 + 0.3 * std::sin(1.7 * at));
  };
  constexpr double h = 1e-4;
  Motion motion;
  motion.attitude_WB = attitude(t);
  motion.body_rate_B_radps = turn_between(attitude(t - h), attitude(t + h)) / (2.0 * h);
  motion.position_W_m = position(t);
  motion.acceleration_W_mps2 = (position(t + h) - 2.0 * position(t) + position(t - h)) / (h * h);
  return motion;
}

struct Fault {
  double gyro_scale = 0.0, pose_delay_s = 0.0;
  Vector3 attitude_offset_B_rad = Vector3::Zero(), lever_B_m = Vector3::Zero(), rate_bias_B_radps = Vector3::Zero();
};

FlightData recorded_with(const VehicleModel& vehicle, const Fault& fault) {
  FlightData flight =
      test::flight_of(vehicle, duration_s, sample_s, swinging, [](double) { return test::all_at(1.0); });
  for (Sample& sample : flight.samples) {
    const Motion here = swinging(sample.time_s), posed = swinging(sample.time_s - fault.pose_delay_s);
    constexpr double h = 1e-4;
    const Vector3 turning =
        (swinging(sample.time_s + h).body_rate_B_radps - swinging(sample.time_s - h).body_rate_B_radps) / (2.0 * h);
    const Vector3& rate = here.body_rate_B_radps;
    sample.channels |= has_force;
    sample.position_W_m = posed.position_W_m;
    sample.attitude_WB = turned(posed.attitude_WB, fault.attitude_offset_B_rad);
    sample.body_rate_B_radps = (1.0 + fault.gyro_scale) * rate + fault.rate_bias_B_radps;
    sample.specific_force_B_mps2 =
        here.attitude_WB.conjugate() * (here.acceleration_W_mps2 + vehicle.gravity_mps2 * Vector3::UnitZ()) +
        turning.cross(fault.lever_B_m) + rate.cross(rate.cross(fault.lever_B_m));
  }
  FlightData read;
  read.sensors = std::make_shared<FlightData>(std::move(flight));
  return read;
}

class SensorWindowsTest : public ::testing::Test {
 protected:
  const VehicleModel vehicle = test::crazyflie();
  const Catalogue catalogue{
      vehicle, 1, {.observable = Need::attitude | Need::motion | Need::gyro | Need::accelerometer}};

  // values of some effects and of the biases that the windows say
  Eigen::VectorXd told(const Fault& fault, const std::vector<std::string>& effects) const {
    const SensorWindows windows = sensor_windows(recorded_with(vehicle, fault), 0, catalogue);
    std::vector<int> columns;
    for (const int c : windows.columns) {
      const int g = catalogue.column(c).group;
      if (g < 0 || std::ranges::count(effects, catalogue.group(g).row->name)) columns.push_back(c);
    }
    const Eigen::VectorXd nominal = catalogue.nominal();
    Grams grams;
    GramBlocks(columns, 0, catalogue.size(), grams)
        .add(whiten_sensor_windows(windows, columns, catalogue, nominal, {1e-6, 1e-6}));
    const Eigen::VectorXd coefficient = solve(grams.total(), columns).coefficient;
    Eigen::VectorXd value = nominal;
    for (std::size_t i = 0; i < columns.size(); ++i)
      value[columns[i]] += coefficient[static_cast<Eigen::Index>(i)] * catalogue.column(columns[i]).natural;
    return value;
  }
  double value_of(const Eigen::VectorXd& value, std::string_view effect, std::size_t parameter = 0) const {
    return value[catalogue.group(catalogue.find(effect)).columns[parameter]];
  }
};

TEST_F(SensorWindowsTest, AgreeWhereNothingIsWrong) {
  const SensorWindows windows = sensor_windows(recorded_with(vehicle, {}), 0, catalogue);
  EXPECT_GT(windows.window.size(), 120u);
  const SensorWindowVariance left = sensor_window_variance({windows}, catalogue, catalogue.nominal());
  EXPECT_LT(std::sqrt(left[0]), 2e-4);  // rad
  EXPECT_LT(std::sqrt(left[1]), 2e-3);  // m/s
}

TEST_F(SensorWindowsTest, TellAGyroscopesScaleBesideItsBias) {
  const Eigen::VectorXd value =
      told({.gyro_scale = 0.03, .rate_bias_B_radps = Vector3(0.02, -0.01, 0.01)}, {"gyro_scale"});
  EXPECT_NEAR(value_of(value, "gyro_scale"), 0.03, 1e-3);
}

TEST_F(SensorWindowsTest, TellATurnedAttitude) {
  const Eigen::VectorXd value =
      told({.attitude_offset_B_rad = Vector3(0.02, -0.03, 0.05)}, {"attitude_offset", "yaw_offset"});
  EXPECT_NEAR(value_of(value, "attitude_offset", 0), 0.02, 2e-3);
  EXPECT_NEAR(value_of(value, "attitude_offset", 1), -0.03, 2e-3);
  EXPECT_NEAR(value_of(value, "yaw_offset"), 0.05, 3e-3);
}

TEST_F(SensorWindowsTest, TellALatePose) {
  EXPECT_NEAR(value_of(told({.pose_delay_s = 0.01}, {"pose_delay"}), "pose_delay"), 0.01, 5e-4);
}

TEST_F(SensorWindowsTest, TellALeverOfTheAccelerometer) {
  const Eigen::VectorXd value = told({.lever_B_m = Vector3(0.02, -0.01, 0.03)}, {"imu_lever"});
  EXPECT_NEAR(value_of(value, "imu_lever", 0), 0.02, 2e-3);
  EXPECT_NEAR(value_of(value, "imu_lever", 1), -0.01, 2e-3);
  EXPECT_NEAR(value_of(value, "imu_lever", 2), 0.03, 3e-3);
}

TEST_F(SensorWindowsTest, StopAtGapsAndAreNoneWithoutInertialData) {
  FlightData flight = recorded_with(vehicle, {});
  const std::size_t all = sensor_windows(flight, 0, catalogue).window.size();
  FlightData gap = *flight.sensors;
  std::erase_if(gap.samples, [](const Sample& s) { return s.time_s > 5.0 && s.time_s < 10.0; });
  flight.sensors = std::make_shared<FlightData>(gap);
  const std::size_t with_gap = sensor_windows(flight, 0, catalogue).window.size();
  EXPECT_NEAR(static_cast<double>(with_gap), 0.75 * static_cast<double>(all), 4.0);
  for (Sample& sample : gap.samples) sample.channels &= ~(has_rate | has_force);
  flight.sensors = std::make_shared<FlightData>(gap);
  EXPECT_TRUE(sensor_windows(flight, 0, catalogue).window.empty());
}

// errors that last count more than they would if they were independent
TEST_F(SensorWindowsTest, ThatErrTogetherAreLessSure) {
  SensorWindows alone, together;
  for (int i = 0; i < 100; ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0, slow = i / 10 % 2 == 0 ? 1.0 : -1.0;
    alone.window.push_back({Beside::gyro, 0.2 * i, Vector3::Constant(sign), Eigen::Matrix3Xd(3, 0)});
    together.window.push_back({Beside::gyro, 0.2 * i, Vector3::Constant(slow), Eigen::Matrix3Xd(3, 0)});
  }
  EXPECT_NEAR(sensor_window_variance({alone}, catalogue, catalogue.nominal())[0], 1.0, 1e-12);
  EXPECT_NEAR(sensor_window_variance({together}, catalogue, catalogue.nominal())[0], 10.0, 1e-12);
}

}  // namespace sensor_windows_test
}  // namespace gustlab::diagnosis
