// A gyro behind its filter: how late it is, and a clean flight with it stays clean.
#include "diagnosis/sensor_lateness.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "support/trials.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double late_s = 0.003;

// the body rate of every recording `by_s` later, between its samples
void delay_gyro(const DiagnoseOptions& trial, double by_s) {
  for (const auto* paths : {&trial.fit, &trial.holdout})
    for (const std::string& path : *paths) {
      FlightLog log = read_flight_log(path);
      for (LogColumn& column : log.columns) {
        if (column.name[0] != 'w') continue;
        const std::vector<double> from = column.values;
        for (std::size_t k = 0; k < from.size(); ++k) {
          const double at = (log.time_s[k] - by_s - log.time_s.front()) / (log.time_s[1] - log.time_s[0]);
          const auto before = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(from.size() - 2)));
          column.values[k] = from[before] + (at - static_cast<double>(before)) * (from[before + 1] - from[before]);
        }
      }
      write_flight_log(log, path);
    }
}

class LateGyro : public ::testing::Test {
 protected:
  DiagnoseOptions fly() const {
    return test::fly_trial(folder_, {.fit = {"multisine", "lemniscate"}, .holdout = {"circle"}, .step_s = 0.0005, .noise = 0.3});
  }
  static double lateness_s(const DiagnoseOptions& trial) {
    std::vector<FlightData> flights;
    const FlightLog first = read_flight_log(trial.fit.front());
    const VehicleModel vehicle = read_vehicle(first.meta.vehicle, first.path);
    for (const std::string& path : trial.fit) flights.push_back(prepare_flight(read_flight_log(path), vehicle, {}));
    return rate_lateness_s(flights);
  }
  TemporaryFolder folder_;
};

TEST_F(LateGyro, IsMeasured) {
  const DiagnoseOptions trial = fly();
  EXPECT_EQ(lateness_s(trial), 0.0);
  delay_gyro(trial, late_s);
  EXPECT_NEAR(lateness_s(trial), late_s, 0.0003);
}

// a pose that is later than the gyro is the dynamics' to tell
TEST_F(LateGyro, IsNeverEarly) {
  const DiagnoseOptions trial = fly();
  delay_gyro(trial, -late_s);
  EXPECT_EQ(lateness_s(trial), 0.0);
}

TEST_F(LateGyro, IsNoMissingPhysics) {
  const DiagnoseOptions trial = fly();
  delay_gyro(trial, late_s);
  const Diagnosis d = diagnose(trial);
  EXPECT_EQ(d.verdict, Verdict::consistent) << to_json(d)["alarms"].dump();
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(d.notes, Contains(HasSubstr("the gyro is 3.")));
}

}  // namespace
}  // namespace gustlab::diagnosis
