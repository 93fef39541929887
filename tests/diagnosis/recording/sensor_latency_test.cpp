// Sensors behind their filters, and poses of an estimator: how late and how lasting, and a clean flight with them stays clean.
#include "diagnosis/recording/sensor_latency.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "support/trials.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace sensor_latency_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double latency_s = 0.003;

class Sensors : public ::testing::Test {
 protected:
  DiagnoseOptions fly(const std::vector<std::string>& sensors = {"pose", "gyroscope"}, double noise = 0.3) const {
    return test::fly_trial(folder_, {.fit = {"multisine", "lemniscate"},
                                     .holdout = {"circle"},
                                     .sensors = sensors,
                                     .step_s = 0.0005,
                                     .noise = noise});
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

class SensorsTrials : public Sensors {};

TEST_F(Sensors, LateGyroIsMeasured) {
  const DiagnoseOptions trial = fly();
  EXPECT_EQ(rate_latency_s(flights_of(trial)), 0.0);
  test::delay(trial, 'w', latency_s);
  EXPECT_NEAR(rate_latency_s(flights_of(trial)), latency_s, 0.0003);
}

// a pose that is later than the gyro is the dynamics' to tell
TEST_F(Sensors, AreNeverEarly) {
  const DiagnoseOptions trial = fly();
  EXPECT_LT(most_pose_latency_s(flights_of(trial)), 0.1 * latency_s);
  test::delay(trial, 'w', -latency_s);
  EXPECT_EQ(rate_latency_s(flights_of(trial)), 0.0);
  EXPECT_NEAR(most_pose_latency_s(flights_of(trial)).value(), latency_s, 0.0003);
}

// what noise hides is not refuted
TEST_F(Sensors, OfNoiseLeaveALatePosePossible) {
  const DiagnoseOptions trial = fly({"pose", "gyroscope"}, 5.0);
  test::delay(trial, 'w', -latency_s);
  const std::vector<FlightData> flights = flights_of(trial);
  EXPECT_EQ(rate_latency_s(flights), 0.0);
  EXPECT_GT(most_pose_latency_s(flights).value(), 0.5 * latency_s);
}

// a simulator that steps velocities first: half a step
TEST_F(Sensors, AreAllBehindThePoseOfASimulatorThatStepsVelocitiesFirst) {
  constexpr double step_s = 0.002;
  const auto as_recorded = [](const DiagnoseOptions& trial) {
    std::vector<FlightData> flights;
    ReadingOptions options;
    options.as_recorded = true;
    for (const std::string& path : trial.fit) {
      const FlightLog log = read_flight_log(path);
      flights.push_back(prepare_flight(log, read_vehicle(log.meta.vehicle, log.path), options));
    }
    return flights;
  };
  const DiagnoseOptions trial = test::fly_trial(folder_, {.fit = {"multisine", "lemniscate"},
                                                          .holdout = {"circle"},
                                                          .sensors = {"pose", "velocity", "gyroscope"},
                                                          .step_s = step_s,
                                                          .noise = 0.01});
  const double late_s = rate_latency_s(flights_of(trial));
  EXPECT_NEAR(late_s, 0.5 * step_s, 0.0001);
  EXPECT_TRUE(steps_velocities_first(as_recorded(trial), late_s));
  // behind a filter the gyro alone is late
  test::delay(trial, 'w', latency_s);
  EXPECT_FALSE(steps_velocities_first(as_recorded(trial), rate_latency_s(flights_of(trial))));
}

TEST_F(Sensors, ReadAPoseThatIsAheadWhenAllElseIs) {
  const DiagnoseOptions trial = test::fly_trial(
      folder_,
      {.fit = {"multisine"}, .holdout = {"circle"}, .sensors = {"pose", "velocity", "gyroscope"}, .noise = 0.01});
  const FlightLog log = read_flight_log(trial.fit.front());
  ReadingOptions put_back;
  put_back.late.pose_ahead_s = 0.001;
  const FlightData flight = prepare_flight(log, read_vehicle(log.meta.vehicle, log.path), put_back);
  EXPECT_NEAR(rate_latency_s({flight}), 0.0, 0.0001);
}

TEST_F(SensorsTrials, LateGyroIsNoMissingPhysics) {
  const DiagnoseOptions trial = fly();
  test::delay(trial, 'w', latency_s);
  const Diagnosis d = diagnose(trial);
  EXPECT_EQ(d.verdict, Verdict::consistent) << to_json(d)["alarms"].dump();
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(d.notes, Contains(HasSubstr("the gyro is 3.")));
}

TEST_F(Sensors, LateAccelerometerIsMeasured) {
  const DiagnoseOptions trial = fly({"pose", "gyroscope", "accelerometer"}, 0.05);
  EXPECT_EQ(force_latency_s(flights_of(trial), latency_s), 0.0);
  test::delay(trial, 'a', latency_s);
  EXPECT_NEAR(force_latency_s(flights_of(trial), 0.0), latency_s, 0.0006);
}

// a scale of the accelerometer is another effect
TEST_F(Sensors, ScaledAccelerometerIsNoLateOne) {
  const DiagnoseOptions trial = fly({"pose", "gyroscope", "accelerometer"}, 0.05);
  test::change(trial, test::begins('a'), [](const FlightLog&, std::vector<double>& values) {
    for (double& value : values) value *= 1.1;
  });
  EXPECT_NEAR(force_latency_s(flights_of(trial), 0.0), 0.0, 0.0003);
  test::delay(trial, 'a', latency_s);
  EXPECT_NEAR(force_latency_s(flights_of(trial), 0.0), latency_s, 0.0006);
}

// where nothing moves, nothing tells
TEST_F(Sensors, LateAccelerometerIsGuessedFromTheGyro) {
  const DiagnoseOptions trial = test::fly_trial(
      folder_, {.fit = {"hover"}, .holdout = {"circle"}, .sensors = {"pose", "gyroscope", "accelerometer"}});
  EXPECT_EQ(force_latency_s(flights_of(trial), latency_s), latency_s);
}

// positions off by 4 mm for a quarter of a second, attitudes by 3 mrad, as an estimator leaves them
TEST_F(SensorsTrials, LastingErrorsAreNoMissingPhysics) {
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
  test::change(trial, test::begins('p'), wander(0.004));
  test::change(trial, test::begins('q'), wander(0.0015));
  const Diagnosis d = diagnose(trial);
  EXPECT_EQ(d.verdict, Verdict::consistent)
      << to_json(d)["alarms"].dump() << to_json(d)["disturbance"].dump() << to_json(d)["notes"].dump();
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(d.notes, Contains(HasSubstr("errors of the sensors last")));
}

}  // namespace sensor_latency_test
}  // namespace gustlab::diagnosis
