// Flights on one clock, with the rotors in the order that the flights show.
#include "diagnosis/alignment/align.hpp"

#include <gmock/gmock.h>

#include <random>

#include "diagnosis/model/command_innovation.hpp"
#include "diagnosis/model/row_acceleration.hpp"
#include "diagnosis/recording/rotor_answer.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace align_test {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;

constexpr double later_s = 0.02;

DiagnoseOptions flown(const TemporaryFolder& folder) {
  return test::fly_trial(folder, {.fit = {"multisine", "lemniscate"}, .holdout = {"circle"}, .duration_s = 10.0});
}

// inputs 1 and 2 were swapped by whoever wrote the log
void swap_inputs(const std::string& path) {
  FlightLog log = read_flight_log(path);
  for (LogColumn& c : log.columns) {
    if (c.name == "u1") c.name = "u2";
    else if (c.name == "u2") c.name = "u1";
  }
  write_flight_log(log, path);
}

// its commands were written down before they were sent
void command_early(const std::string& path) {
  FlightLog log = read_flight_log(path);
  const auto shift = static_cast<std::size_t>(std::lround(later_s / (log.time_s[1] - log.time_s[0])));
  for (LogColumn& c : log.columns)
    if (c.name[0] == 'u')
      for (std::size_t k = 0; k + 1 < c.values.size(); ++k)
        c.values[k] = c.values[std::min(k + shift, c.values.size() - 1)];
  write_flight_log(log, path);
}

// of the commands of a faster loop each row has one
void sample_jitter(const DiagnoseOptions& trial) {
  for (const auto* paths : {&trial.fit, &trial.holdout})
    for (const std::string& path : *paths) {
      FlightLog log = read_flight_log(path);
      log.meta.hold = Hold::unknown;
      std::mt19937 random(7);
      std::normal_distribution<double> normal(0.0, 25.0);  // rad/s
      for (std::size_t k = 0; k < log.time_s.size(); ++k) {
        const double all = normal(random);
        for (LogColumn& c : log.columns)
          if (c.name[0] == 'u') {
            c.values[k] += normal(random) + 10.0 * all;
          }
      }
      write_flight_log(log, path);
    }
}

// what check says of a gyro that no course of its clock lays on the pose's
Recordings with_clocks_apart(const DiagnoseOptions& trial) {
  Recordings recordings = check(read_recordings(trial.fit, trial.holdout, {}, std::nullopt));
  recordings.remarks.findings.push_back(
      {label_of(recordings.fit.front().path), "wx…az", "delay", 0.0, 1.0, "two clocks", false, true});
  return recordings;
}

Aligned aligned(const DiagnoseOptions& trial) {
  return align(check(read_recordings(trial.fit, trial.holdout, {}, std::nullopt)));
}

TEST(Align, LeavesFlightsThatAgreeAsTheyAre) {
  const TemporaryFolder folder;
  const Aligned found = aligned(flown(folder));
  EXPECT_TRUE(found.remarks.findings.empty());
  for (const double offset_s : found.offset_s) EXPECT_EQ(offset_s, 0.0);
}

TEST(Align, FindsTheFlightWhoseCommandsAreEarly) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = flown(folder);
  command_early(trial.fit[1]);
  const Aligned found = aligned(trial);
  ASSERT_EQ(found.offset_s.size(), 3u);
  EXPECT_EQ(found.offset_s[0], 0.0);
  EXPECT_NEAR(found.offset_s[1], later_s, 0.004);
  EXPECT_EQ(found.offset_s[2], 0.0);
}

// its held-out part is on the same clock, whatever its commands seem to say
TEST(Align, LooksForNoOffsetBetweenPartsOfOneRecording) {
  const TemporaryFolder folder;
  DiagnoseOptions trial = flown(folder);
  trial.fit.resize(1);
  trial.holdout.clear();
  FlightLog log = read_flight_log(trial.fit[0]);
  const auto shift = static_cast<std::size_t>(std::lround(later_s / (log.time_s[1] - log.time_s[0])));
  for (LogColumn& c : log.columns)
    if (c.name[0] == 'u')
      for (std::size_t k = 0; k < c.values.size() * 2 / 3; ++k) c.values[k] = c.values[k + shift];
  write_flight_log(log, trial.fit[0]);
  const Aligned found = align(with_held_out_part(check(read_recordings(trial.fit, {}, {}, std::nullopt))));
  for (const double offset_s : found.offset_s) EXPECT_EQ(offset_s, 0.0);
}

// under the order that the file lists, torques say nothing of when commands were sent
TEST(Align, JudgesOffsetsInTheRotorOrderThatTheFlightsShow) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = flown(folder);
  for (const auto* paths : {&trial.fit, &trial.holdout})
    for (const std::string& path : *paths) swap_inputs(path);
  command_early(trial.fit[1]);
  const Aligned found = aligned(trial);
  EXPECT_THAT(found.remarks.findings, Contains(Field(&LogFinding::says, HasSubstr("the file lists as 2, 1, 3, 4"))));
  ASSERT_EQ(found.offset_s.size(), 3u);
  EXPECT_EQ(found.offset_s[0], 0.0);
  EXPECT_NEAR(found.offset_s[1], later_s, 0.004);
  EXPECT_EQ(found.offset_s[2], 0.0);
}

TEST(Align, JudgesForcesAloneWhereTheLogsAreOnTwoClocks) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = flown(folder);
  EXPECT_FALSE(aligned(trial).reading.forces_only);
  EXPECT_TRUE(align(with_clocks_apart(trial)).reading.forces_only);
}

// forces alone for another reason do not make commands known that jitter
TEST(Align, SaysThatCommandsJitterWhereTheClocksAreApartToo) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = flown(folder);
  sample_jitter(trial);
  const Aligned found = align(with_clocks_apart(trial));
  EXPECT_TRUE(found.reading.forces_only);
  EXPECT_TRUE(found.commands_jitter);
}

// A loop at 500 Hz that sets new attitudes at 50 Hz, on the rows of its log: measured speeds of a row are those before its commands.
test::TrialSettings on_the_rows() {
  return {.vehicle = "neurobem_racer",
          .controller = "mpc",
          .fit = {"multisine"},
          .holdout = {"circle"},
          .sensors = {"pose", "gyroscope", "rotor_speed"},
          .duration_s = 10.0,
          .log_rate_hz = 50.0,
          .noise = 0.0,
          .air_sd_N = 0.05};
}

Aligned settled(const test::TrialSettings& trial) {
  const TemporaryFolder folder;
  const DiagnoseOptions flown = test::fly_trial(folder, trial);
  Aligned aligned = align(check(read_recordings(flown.fit, flown.holdout, {}, std::nullopt)));
  settle_between_rows(aligned);
  return aligned;
}

// Roll acceleration from row to row over that of the rotors.
double gain(const Aligned& aligned) {
  const FlightData flight = prepare(aligned.fit, aligned.vehicle, {}).front();
  const std::vector<Eigen::Vector4d> rotors = rotor_acceleration(flight);
  double both = 0.0, squared = 0.0;
  for (std::size_t k = 50; k + 1 < flight.samples.size(); ++k) {
    const Sample &now = flight.samples[k], &next = flight.samples[k + 1];
    both += rotors[k].x() * (next.body_rate_B_radps.x() - now.body_rate_B_radps.x()) / (next.time_s - now.time_s);
    squared += rotors[k].x() * rotors[k].x();
  }
  return both / squared;
}

TEST(MeasuredSpeeds, JumpToTheCommandsOfTheirRows) {
  Aligned aligned = settled(on_the_rows());
  ASSERT_EQ(aligned.fit.front().meta.between_rows, BetweenRows::from_command_to_speed);
  ASSERT_EQ(aligned.holdout.front().meta.between_rows, BetweenRows::from_command_to_speed);
  EXPECT_THAT(aligned.remarks.notes, Contains(HasSubstr("obey at once")));
  EXPECT_NEAR(gain(aligned), 1.0, 0.02);
  aligned.fit.front().meta.between_rows = BetweenRows::as_said;
  EXPECT_GT(gain(aligned), 1.1);
}

TEST(MeasuredSpeeds, DoNotJumpWhereRotorsAreSlowOrNotMeasured) {
  test::TrialSettings slow = on_the_rows(), known = on_the_rows(), unmeasured = on_the_rows();
  slow.controller = "geometric";  // mpc does not hold it
  slow.concealed = R"({type = "motor_lag", time_constant = 0.06})";
  known.vehicle = "crazyflie";  // with a lag in its file
  unmeasured.sensors = {"pose", "gyroscope"};
  for (const test::TrialSettings& trial : {slow, known, unmeasured})
    EXPECT_NE(settled(trial).fit.front().meta.between_rows, BetweenRows::from_command_to_speed);
}

// Share of the variance of the roll acceleration from row to row that the rotors leave.
double left(const Aligned& aligned) {
  const std::vector<FlightData> flights = {prepare(aligned.fit, aligned.vehicle, {}).front()};
  return acceleration_left(flights, {rotor_acceleration(flights.front())}, 0.0).front().share;
}

// Every command of the loop is logged: speeds go to the next row as the file's rotors answer, also where a delay of whole rows is concealed.
TEST(MeasuredSpeeds, AreKnownBetweenRowsThatHaveEachCommand) {
  test::TrialSettings prompt = on_the_rows(), late = on_the_rows();
  late.concealed = R"({type = "actuation_delay", delay = 0.01})";
  for (test::TrialSettings* trial : {&prompt, &late}) {
    trial->log_rate_hz = 0.0;
    Aligned aligned = settled(*trial);
    ASSERT_EQ(aligned.fit.front().meta.between_rows, BetweenRows::as_answered) << trial->concealed;
    const double known = left(aligned);
    aligned.fit.front().meta.between_rows = BetweenRows::as_said;
    EXPECT_LT(known, 0.1 * left(aligned)) << trial->concealed;
  }
}

TEST(MeasuredSpeeds, GoFromRowToRowAlongTheLagOfTheFile) {
  test::TrialSettings trial = on_the_rows();
  trial.vehicle = "crazyflie";
  trial.log_rate_hz = 0.0;
  const Aligned aligned = settled(trial);
  ASSERT_EQ(aligned.fit.front().meta.between_rows, BetweenRows::as_answered);
  const FlightData flight = prepare(aligned.fit, aligned.vehicle, {}).front();
  const RotorAnswer answer(flight.vehicle);
  const auto& [time_s, speed] = std::pair(flight.measured_speed.time_s(), flight.measured_speed.speed_radps());
  double astray = 0.0, straight = 0.0;
  for (std::size_t k = 0; k + 1 < time_s.size(); ++k) {
    const double row_s = time_s[k + 1] - time_s[k];
    double mean = 0.0;
    constexpr int parts = 100;
    for (int part = 0; part < parts; ++part)
      mean += answer.after((part + 0.5) / parts * row_s, speed[k], flight.commands.speed_radps()[k])[0] / parts;
    astray += std::pow(flight.jumping_speed.mean(time_s[k], time_s[k + 1])[0] - mean, 2);
    straight += std::pow(0.5 * (speed[k][0] + speed[k + 1][0]) - mean, 2);
  }
  EXPECT_LT(astray, 0.02 * straight);
}

TEST(MeasuredSpeeds, AreNotWhereRotorsAnswerOtherwise) {
  test::TrialSettings slow = on_the_rows();
  slow.controller = "geometric";
  slow.concealed = R"({type = "motor_lag", time_constant = 0.02})";
  slow.log_rate_hz = 0.0;
  EXPECT_EQ(settled(slow).fit.front().meta.between_rows, BetweenRows::as_said);
}

// Commands alone show a quarter more torque than there is.
TEST(CommandsAlone, SayThatTheLoopGoesOn) {
  test::TrialSettings trial = on_the_rows();
  trial.sensors = {"pose", "gyroscope"};
  EXPECT_EQ(settled(trial).fit.front().meta.between_rows, BetweenRows::loop_goes_on);
  trial.log_rate_hz = 500.0;
  EXPECT_EQ(settled(trial).fit.front().meta.between_rows, BetweenRows::as_said);
}

TEST(CommandsAloneTrials, NameNoMomentsOfInertia) {
  const TemporaryFolder folder;
  test::TrialSettings trial = on_the_rows();
  trial.sensors = {"pose", "velocity", "gyroscope", "accelerometer"};
  trial.concealed = R"({type = "mass", delta = 0.1})";
  const Diagnosis found = diagnose(test::fly_trial(folder, trial));
  ASSERT_EQ(found.effects.size(), 1u);
  EXPECT_THAT(found.effects.front().classmates, Contains("mass"));
  EXPECT_THAT(found.notes, Contains(HasSubstr("goes on between them")));
}

// Read as straight lines the speeds showed a quarter less torque, and a right moment of inertia a quarter less.
TEST(MeasuredSpeedsTrials, GiveTheMomentsOfInertia) {
  const TemporaryFolder folder;
  test::TrialSettings trial = on_the_rows();
  trial.concealed = R"({type = "inertia", delta_x = 0.3, delta_y = 0.3})";
  const Diagnosis found = diagnose(test::fly_trial(folder, trial));
  ASSERT_EQ(found.effects.size(), 1u);
  EXPECT_EQ(found.effects.front().effect, "inertia");
  for (const NamedValue& delta : found.effects.front().parameters)
    if (delta.name != "delta_z") {
      EXPECT_NEAR(delta.value, 0.3, 0.02);
    }
}

}  // namespace align_test
}  // namespace gustlab::diagnosis
