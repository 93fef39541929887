// Sensors behind their filters, and poses of an estimator: how late and how lasting, and a clean flight with them stays clean.
#include "diagnosis/sensor_lateness.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "support/trials.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double late_s = 0.003;

template <class How>
void change(const DiagnoseOptions& trial, char initial, How how) {
  test::change_recordings(trial, [initial](const std::string& name) { return name[0] == initial; }, how);
}

// `by_s` later, between samples
void delay(const DiagnoseOptions& trial, char initial, double by_s) {
  change(trial, initial, [by_s](const FlightLog& log, std::vector<double>& values) {
    const std::vector<double> from = values;
    for (std::size_t k = 0; k < from.size(); ++k) {
      const double at = (log.time_s[k] - by_s - log.time_s.front()) / (log.time_s[1] - log.time_s[0]);
      const auto before = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(from.size() - 2)));
      values[k] = from[before] + (at - static_cast<double>(before)) * (from[before + 1] - from[before]);
    }
  });
}

class Sensors : public ::testing::Test {
 protected:
  DiagnoseOptions fly(const std::vector<std::string>& sensors = {"pose", "gyroscope"}, double noise = 0.3) const {
    return test::fly_trial(folder_, {.fit = {"multisine", "lemniscate"}, .holdout = {"circle"}, .sensors = sensors, .step_s = 0.0005, .noise = noise});
  }
  static std::vector<FlightData> flights_of(const DiagnoseOptions& trial) {
    std::vector<FlightData> flights;
    const FlightLog first = read_flight_log(trial.fit.front());
    const VehicleModel vehicle = read_vehicle(first.meta.vehicle, first.path);
    for (const std::string& path : trial.fit) flights.push_back(prepare_flight(read_flight_log(path), vehicle, {}));
    return flights;
  }
  TemporaryFolder folder_;
};

TEST_F(Sensors, LateGyroIsMeasured) {
  const DiagnoseOptions trial = fly();
  EXPECT_EQ(rate_lateness_s(flights_of(trial)), 0.0);
  delay(trial, 'w', late_s);
  EXPECT_NEAR(rate_lateness_s(flights_of(trial)), late_s, 0.0003);
}

// a pose that is later than the gyro is the dynamics' to tell
TEST_F(Sensors, AreNeverEarly) {
  const DiagnoseOptions trial = fly();
  EXPECT_EQ(pose_lateness_s(flights_of(trial)), 0.0);
  delay(trial, 'w', -late_s);
  EXPECT_EQ(rate_lateness_s(flights_of(trial)), 0.0);
  EXPECT_NEAR(pose_lateness_s(flights_of(trial)), late_s, 0.0003);
}

TEST_F(Sensors, LateGyroIsNoMissingPhysics) {
  const DiagnoseOptions trial = fly();
  delay(trial, 'w', late_s);
  const Diagnosis d = diagnose(trial);
  EXPECT_EQ(d.verdict, Verdict::consistent) << to_json(d)["alarms"].dump();
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(d.notes, Contains(HasSubstr("the gyro is 3.")));
}

TEST_F(Sensors, LateAccelerometerIsMeasured) {
  const DiagnoseOptions trial = fly({"pose", "gyroscope", "accelerometer"}, 0.05);
  EXPECT_EQ(force_lateness_s(flights_of(trial), late_s), 0.0);
  delay(trial, 'a', late_s);
  EXPECT_NEAR(force_lateness_s(flights_of(trial), 0.0), late_s, 0.0006);
}

// where nothing moves, nothing tells
TEST_F(Sensors, LateAccelerometerIsGuessedFromTheGyro) {
  const DiagnoseOptions trial = test::fly_trial(folder_, {.fit = {"hover"}, .holdout = {"circle"}, .sensors = {"pose", "gyroscope", "accelerometer"}});
  EXPECT_EQ(force_lateness_s(flights_of(trial), late_s), late_s);
}

// positions off by 4 mm for a quarter of a second, attitudes by 3 mrad, as an estimator leaves them
TEST_F(Sensors, LastingErrorsAreNoMissingPhysics) {
  const DiagnoseOptions trial = fly();
  std::mt19937_64 random(3);
  const auto wander = [&](double sd) {
    return [&random, sd](const FlightLog& log, std::vector<double>& values) {
      const double decay = std::exp(-(log.time_s[1] - log.time_s[0]) / 0.25);
      std::normal_distribution<double> normal;
      double error = sd * normal(random);
      for (double& value : values) {
        value += error;
        error = decay * error + std::sqrt(1.0 - decay * decay) * sd * normal(random);
      }
    };
  };
  change(trial, 'p', wander(0.004));
  change(trial, 'q', wander(0.0015));
  const Diagnosis d = diagnose(trial);
  EXPECT_EQ(d.verdict, Verdict::consistent) << to_json(d)["alarms"].dump() << to_json(d)["disturbance"].dump() << to_json(d)["notes"].dump();
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(d.notes, Contains(HasSubstr("errors of the sensors last")));
}

}  // namespace
}  // namespace gustlab::diagnosis
