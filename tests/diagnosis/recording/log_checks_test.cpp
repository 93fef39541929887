// Faults of logs whose columns have rates and rows of their own: what lies between the samples of a slow column is no sample, and hides no fault.
#include "diagnosis/recording/log_checks.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "support/closed_form_flights.hpp"

namespace gustlab::diagnosis {
namespace log_checks_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using test::column;
using test::racer;

using Names = std::initializer_list<const char*>;

constexpr Names position = {"px", "py", "pz"}, velocity = {"vx", "vy", "vz"}, attitude = {"qw", "qx", "qy", "qz"},
                gyro = {"wx", "wy", "wz"}, accelerometer = {"ax", "ay", "az"}, inputs = {"u1", "u2", "u3", "u4"};

// a column keeps every so many rows
void keep(FlightLog& log, Names names, std::size_t every, std::size_t from) {
  for (const char* name : names)
    for (std::size_t k = 0; k < log.rows(); ++k)
      if (k % every != from) column(log, name)[k] = std::numeric_limits<double>::quiet_NaN();
}

// 250 rows a second; inertial data at 125 Hz, inputs at 50, attitudes and velocities at 25, positions at
// 12.5, these three on rows of their own
FlightLog at_own_rates(const test::Path& path) {
  FlightLog log = test::fly(path, racer(), 0.004);
  keep(log, gyro, 2, 0), keep(log, accelerometer, 2, 0);
  keep(log, inputs, 5, 2);
  keep(log, attitude, 10, 1), keep(log, velocity, 10, 3), keep(log, position, 20, 5);
  return log;
}

// sample number i of a column, as a function of the one before it (NaN for the first)
void change(FlightLog& log, const char* name, const std::function<double(double value, double before, int i)>& to) {
  double before = std::numeric_limits<double>::quiet_NaN();
  int i = 0;
  for (double& value : column(log, name))
    if (std::isfinite(value)) value = before = to(value, before, i++);
}

std::vector<std::string> says(FlightLog log) {
  std::vector<std::string> texts;
  for (const LogFinding& finding : check_log(log, racer())) texts.push_back(finding.column + " " + finding.says);
  return texts;
}

TEST(LogChecksOfSlowColumns, SayNothingOfARightLog) {
  for (const auto& path : {test::hover, test::banked, test::loop}) EXPECT_THAT(says(at_own_rates(path)), IsEmpty());
}

TEST(LogChecksOfSlowColumns, FindInputsThatNeverChange) {
  FlightLog log = at_own_rates(test::hover);
  change(log, "u3", [](double, double, int) { return 1200.0; });
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("1 of 4 inputs never change")));
}

TEST(LogChecksOfSlowColumns, FindInterpolatedInputsButNotCoarseOnes) {
  FlightLog log = at_own_rates(test::hover);
  const auto line = [](int from, int to) {
    return [=](double value, double before, int i) { return i > from && i <= to ? before + 0.5 : value; };
  };
  change(log, "u1", line(100, 140));
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("a straight line for 0.8 s")));
  // nor is a quiet simulation's slow swing one: it bends by less than 1e-9 of the largest input
  log = test::fly(test::hover, racer(), 0.004);
  for (const char* name : inputs) {
    const double hover = column(log, name).front();
    change(log, name, [=](double, double, int i) { return hover + 0.02 * std::sin(0.002 * i); });
  }
  EXPECT_THAT(says(log), IsEmpty());
  // seven steps of one size in a row are chance where values are coarse
  log = at_own_rates(test::hover);
  keep(log, inputs, 25, 2);
  change(log, "u1", line(30, 37));
  EXPECT_THAT(says(log), IsEmpty());
}

TEST(LogChecksOfSlowColumns, CountShareOfSamplesNotOfRows) {
  FlightLog log = at_own_rates(test::hover);
  change(log, "u2", [](double, double, int) { return -5.0; });
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("25.0 % of the inputs are outside")));
}

TEST(LogChecksOfSlowColumns, FindColumnsThatStandStill) {
  FlightLog log = at_own_rates(test::hover);
  change(log, "pz", [](double, double, int) { return 1.0; });
  EXPECT_THAT(says(log), ElementsAre("pz never changes: not used"));

  log = at_own_rates(test::hover);
  change(log, "py", [](double value, double before, int i) { return i > 30 && i <= 50 ? before : value; });
  EXPECT_THAT(says(log), ElementsAre("py stands still for 1.60 s: not used there"));
}

// a vehicle that flies along x stands still in y to the millimetre, where it turns round
TEST(LogChecksOfSlowColumns, TakeAStandOfACoarseColumnForFlight) {
  FlightLog log = at_own_rates(test::hover);
  for (const char* name : position)
    change(log, name, [](double value, double, int) { return std::round(1e3 * value) / 1e3; });
  change(log, "py", [](double value, double before, int i) { return i > 30 && i <= 50 ? before : value; });
  EXPECT_THAT(says(log), IsEmpty());
}

TEST(LogChecksOfSlowColumns, FindForwardFilledSensorsButNotCoarseOnes) {
  FlightLog log = at_own_rates(test::hover);
  for (const char* name : accelerometer)
    change(log, name, [](double value, double before, int i) { return i % 2 == 1 ? before : value; });
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("ax 50 % of its samples repeat the one before"), HasSubstr("ay 50 %"),
                                     HasSubstr("az 50 %")));
  check_log(log, racer());
  const auto& left = column(log, "ax");
  const auto samples = std::count_if(left.begin(), left.end(), [](double v) { return std::isfinite(v); });
  EXPECT_EQ(samples, static_cast<std::ptrdiff_t>(log.rows() / 4));

  // a gyro in whole degrees per second repeats each of its values half of the time, and seldom all three
  log = at_own_rates(test::hover);
  for (const char* name : gyro)
    change(log, name, [](double value, double, int) { return std::round(value / 0.0175) * 0.0175; });
  EXPECT_THAT(says(log), IsEmpty());
}

// an attitude of ten bits changes by one step at a time, and repeats in all of its columns while it turns slowly
TEST(LogChecksOfSlowColumns, KeepACoarseAttitudeThatMovesByOneStep) {
  FlightLog log = at_own_rates(test::hover);
  for (const char* name : {"qx", "qy", "qz"})
    change(log, name, [](double, double, int i) { return 0.002 * ((i / 3) % 2) - 0.002; });
  change(log, "qw",
         [](double, double, int i) { return std::sqrt(1.0 - 3.0 * std::pow(0.002 * ((i / 3) % 2) - 0.002, 2)); });
  std::vector<std::string> held;
  for (const std::string& text : says(log))
    if (text.find("forward-filled") != std::string::npos) held.push_back(text);
  EXPECT_THAT(held, IsEmpty());
}

TEST(LogChecksOfSlowColumns, CompareAGyroWithAttitudesOfOtherRows) {
  const FlightLog right = at_own_rates(test::loop);
  for (const auto& [by, words] : {std::pair(57.2958, "is in degrees per second"), std::pair(-1.0, "opposite sign")}) {
    FlightLog log = right;
    for (const char* name : gyro) change(log, name, [&, by = by](double value, double, int) { return by * value; });
    EXPECT_THAT(says(log), ElementsAre(HasSubstr(words))) << by;
  }
}

TEST(LogChecksOfSlowColumns, CompareAVelocityWithPositionsOfOtherRows) {
  FlightLog log = test::fly(test::banked, racer(), 0.004);
  for (std::size_t k = 0; k < log.rows(); ++k) {
    const Quaternion q(column(log, "qw")[k], column(log, "qx")[k], column(log, "qy")[k], column(log, "qz")[k]);
    const Vector3 in_B = q.conjugate() * Vector3(column(log, "vx")[k], column(log, "vy")[k], column(log, "vz")[k]);
    for (int i = 0; i < 3; ++i) column(log, velocity.begin()[i])[k] = in_B[i];
  }
  keep(log, attitude, 10, 1), keep(log, velocity, 10, 3), keep(log, position, 10, 5);
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("velocity is in body axes")));
}

TEST(LogChecksOfSlowColumns, CompareAVelocityBehindAGapOfThePose) {
  FlightLog log = test::fly(test::banked, racer());
  for (const Names& names : {position, attitude})
    for (const char* name : names)
      for (std::size_t k = 200; k < 330; ++k) column(log, name)[k] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("no pose for 1.31 s")));
}

TEST(LogChecksOfSlowColumns, MeasureTimeOnTheGroundByTheClock) {
  FlightLog log = test::fly(test::hover, racer(), 0.004);
  // rows come in pairs, 1 ms and 7 ms apart
  for (std::size_t k = 1; k < log.rows(); k += 2) log.time_s[k] -= 0.003;
  for (std::size_t k = 0; k < log.rows(); ++k)
    if (log.time_s[k] >= 6.0)
      for (const char* name : inputs) column(log, name)[k] = 100.0 + static_cast<double>(k % 7);
  EXPECT_THAT(says(log), ElementsAre(HasSubstr("2.0 s with rotors too slow to fly")));
}

// within an infinite tolerance everything is a straight line
TEST(LogChecksOfInputs, WithoutALargestInputInTheVehicleFileAreNoStraightLine) {
  VehicleModel vehicle = racer();
  vehicle.max_speed_radps = std::numeric_limits<double>::infinity();
  FlightLog log = test::fly(test::loop, vehicle);
  for (const LogFinding& finding : check_log(log, vehicle)) EXPECT_FALSE(finding.sets_flight_aside) << finding.says;
}

}  // namespace log_checks_test
}  // namespace gustlab::diagnosis
