// Commands that were sampled from a faster loop are told from commands that were logged whole.
#include "diagnosis/recording/command_jitter.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "support/trials.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace command_jitter_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

// 20 s of a Crazyflie's commands at 100 Hz: roll and pitch swing at 1 and 1.5 Hz, and every rotor jitters
FlightData commanded(double swing_radps, double jitter_radps) {
  FlightData flight;
  flight.vehicle = test::crazyflie();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  for (int k = 0; k < 2000; ++k) {
    time_s.push_back(0.01 * k);
    RotorArray row{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3 hub = flight.vehicle.rotors[i].position_B_m;
      row[i] = flight.vehicle.hover_speed_radps() + jitter_radps * normal(random) +
               swing_radps * (std::copysign(1.0, hub.y()) * std::sin(2.0 * pi * time_s.back()) +
                              std::copysign(1.0, hub.x()) * std::sin(3.0 * pi * time_s.back()));
    }
    speed.push_back(row);
    flight.samples.push_back({.time_s = time_s.back()});
  }
  flight.commands = CommandRecord(time_s, speed, false);
  return flight;
}

double command_share(const FlightData& flight) { return command_jitter_share({&flight}); }
double thrust_share(const FlightData& flight) { return thrust_jitter_share({&flight}); }

TEST(CommandJitter, IsTheWhiteShareOfTheCommandedTorque) {
  EXPECT_LT(command_share(commanded(50.0, 0.0)), 0.01);
  EXPECT_GT(command_share(commanded(0.0, 50.0)), 0.85);
  // four rotors swing together (variance 4² 50²/2) and jitter alone (4 · 40²)
  EXPECT_NEAR(command_share(commanded(50.0, 40.0)), 6400.0 / (6400.0 + 20000.0), 0.03);
}

// set points at 100 Hz beside an inertial unit at 500 Hz
TEST(CommandJitter, IsThatOfTheCommandsWhateverElseIsLoggedFaster) {
  for (const double jitter_radps : {0.0, 40.0}) {
    FlightData flight = commanded(50.0, jitter_radps);
    const double slow = command_share(flight);
    const std::vector<Sample> samples = flight.samples;
    flight.samples.clear();
    for (const Sample& sample : samples)
      for (int k = 0; k < 5; ++k) flight.samples.push_back({.time_s = sample.time_s + 0.002 * k});
    EXPECT_NEAR(command_share(flight), slow, 0.02);
  }
}

// one axis that jitters is enough, whichever it is
TEST(CommandJitter, IsThatOfTheAxisThatJittersMore) {
  for (const int axis : {0, 1}) {
    FlightData flight = commanded(50.0, 0.0);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<RotorArray> speed = flight.commands.speed_radps();
    for (RotorArray& row : speed) {
      const double jitter_radps = 200.0 * normal(random);
      // a moment about x comes from levers along y
      for (std::size_t i = 0; i < 4; ++i)
        row[i] += std::copysign(jitter_radps, flight.vehicle.rotors[i].position_B_m[1 - axis]);
    }
    flight.commands = CommandRecord(flight.commands.time_s(), speed, false);
    EXPECT_GT(command_share(flight), 0.7) << axis;
  }
}

// before take-off and after landing commands may jitter
TEST(CommandJitter, OutsideOfTheFlightDoesNotCount) {
  FlightData flight = commanded(50.0, 0.0);
  std::vector<RotorArray> speed = flight.commands.speed_radps();
  const std::vector<RotorArray> jittering = commanded(50.0, 200.0).commands.speed_radps();
  std::copy(jittering.begin(), jittering.begin() + 800, speed.begin());
  std::copy(jittering.begin() + 1200, jittering.end(), speed.begin() + 1200);
  flight.commands = CommandRecord(flight.commands.time_s(), speed, false);
  flight.samples = {flight.samples.begin() + 800, flight.samples.begin() + 1200};
  flight.start_s = flight.samples.front().time_s;
  EXPECT_LT(command_share(flight), 0.01);
}

// variances 6400 and 20000 beside 6400 alone
TEST(CommandJitter, OfSeveralFlightsIsThatOfAllTogether) {
  const FlightData swings = commanded(50.0, 40.0), hovers = commanded(0.0, 40.0);
  EXPECT_NEAR(command_jitter_share({&swings, &hovers}), 12800.0 / (12800.0 + 20000.0), 0.03);
}

// rotors that follow slowly have speeds that are smooth; speeds that are measured badly say less than smooth commands
TEST(CommandJitter, IsTheSmallerOneOfCommandsAndMeasuredSpeeds) {
  FlightData flight = commanded(50.0, 40.0);
  flight.vehicle.effects.clear();
  flight.measured_speed = commanded(50.0, 0.0).commands;
  EXPECT_LT(command_share(flight), 0.01);
  std::swap(flight.commands, flight.measured_speed);
  EXPECT_LT(command_share(flight), 0.01);
  // those of one flight of two do not tell what is fitted to both
  std::swap(flight.commands, flight.measured_speed);
  FlightData commands_alone = flight;
  commands_alone.measured_speed = {};
  EXPECT_NEAR(command_jitter_share({&flight, &commands_alone}), 6400.0 / (6400.0 + 20000.0), 0.03);
  // nor do those of rotors that are late by their file
  flight.vehicle.effects = test::crazyflie().effects;
  EXPECT_NEAR(command_share(flight), 6400.0 / (6400.0 + 20000.0), 0.03);
}

TEST(CommandJitter, OfTheTorquesLeavesTheThrust) {
  FlightData flight = commanded(0.0, 0.0);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> time_s;
  std::vector<RotorArray> speed;
  const double hover = flight.vehicle.hover_speed_radps();
  for (const Sample& sample : flight.samples) {
    time_s.push_back(sample.time_s);
    const double roll = 0.1 * normal(random), climb = 0.1 * std::sin(2.0 * pi * sample.time_s);
    RotorArray row{};
    for (std::size_t i = 0; i < 4; ++i)
      row[i] = hover * std::sqrt(1.0 + climb + std::copysign(roll, flight.vehicle.rotors[i].position_B_m.y()));
    speed.push_back(row);
  }
  flight.commands = CommandRecord(time_s, speed, false);
  EXPECT_GT(command_share(flight), 0.7);
  EXPECT_LT(thrust_share(flight), 0.01);
}

// a 500 Hz loop, logged at 100 Hz; the geometric controller's commands change at every tick, those of PID hardly do
test::TrialSettings sampled_loop(const char* controller, double noise) {
  return {.controller = controller,
          .fit = {"multisine"},
          .holdout = {"circle"},
          .duration_s = 8.0,
          .log_rate_hz = 100.0,
          .noise = noise};
}

// with sidecars that say this of the commands
Diagnosis diagnose_saying(const DiagnoseOptions& trial, Hold hold) {
  for (const auto* paths : {&trial.fit, &trial.holdout})
    for (const std::string& path : *paths) {
      FlightLog log = read_flight_log(path);
      log.meta.hold = hold;
      write_flight_log(log, path);
    }
  return diagnose(trial);
}

std::vector<std::string> finding_kinds(const Diagnosis& d) {
  std::vector<std::string> kinds;
  for (const LogFinding& finding : d.log_findings) kinds.push_back(finding.kind);
  return kinds;
}

TEST(CommandJitterTrials, OfASampledLoopMakesTheLogInsufficient) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, sampled_loop("geometric", 1.0));
  const Diagnosis d = diagnose_saying(trial, Hold::unknown);
  EXPECT_EQ(d.verdict, Verdict::insufficient_data);
  EXPECT_THAT(d.effects, IsEmpty());
  EXPECT_THAT(finding_kinds(d), Contains("inconsistent"));

  // a log that says how its commands are held is believed
  const Diagnosis believed = diagnose_saying(trial, Hold::zoh);
  EXPECT_NE(believed.verdict, Verdict::insufficient_data);
  EXPECT_THAT(finding_kinds(believed), IsEmpty());
}

TEST(CommandJitterTrials, LeavesWhatTheForcesTell) {
  const TemporaryFolder folder;
  test::TrialSettings settings = sampled_loop("geometric", 1.0);
  settings.concealed = R"({type = "rotor_drag", at_hover = 0.03})";
  const Diagnosis d = diagnose_saying(test::fly_trial(folder, settings), Hold::unknown);
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "rotor_drag");
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.03, 0.009);
}

// torques over two seconds are known where those from sample to sample are not
TEST(CommandJitterTrials, LeavesWhatShiftsTheTorques) {
  const TemporaryFolder folder;
  test::TrialSettings settings = sampled_loop("geometric", 1.0);
  settings.duration_s = 20.0;
  settings.concealed = R"({type = "center_of_mass", x = 0.002, y = -0.001})";
  const Diagnosis d = diagnose_saying(test::fly_trial(folder, settings), Hold::unknown);
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "center_of_mass") << to_json(d).dump(1);
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.002, 2e-4);
  EXPECT_NEAR(d.effects[0].parameters[1].value, -0.001, 2e-4);
  EXPECT_FALSE(d.torque_told);
}

// of one rotor of four an eighth is three percent of the thrust, and a twentieth is what a vehicle file does not know
TEST(CommandJitterTrials, LeavesALostRotorThatTheThrustTells) {
  const auto found_of = [](double loss) {
    const TemporaryFolder folder;
    test::TrialSettings settings = sampled_loop("geometric", 1.0);
    settings.duration_s = 20.0;
    settings.concealed = fmt::format("{{type = \"rotor_loss\", rotor = 2, loss = {}}}", loss);
    return diagnose_saying(test::fly_trial(folder, settings), Hold::unknown);
  };
  const Diagnosis told = found_of(0.12);
  ASSERT_EQ(told.effects.size(), 1u) << to_json(told).dump(1);
  EXPECT_EQ(told.effects[0].effect, "rotor_loss");
  EXPECT_EQ(told.effects[0].rotor(), 2);
  EXPECT_NEAR(test::value_of(told.effects[0], "loss"), 0.12, 0.02);
  EXPECT_THAT(found_of(0.05).effects, Not(Contains(Field(&EffectFinding::effect, "rotor_loss"))));
}

// rotors that are slower than the loop do not follow its jitter: their measured speeds tell what turns the body
TEST(CommandJitterTrials, LeavesTheTorquesThatMeasuredSpeedsTell) {
  const TemporaryFolder folder;
  test::TrialSettings settings = sampled_loop("geometric", 1.0);
  settings.vehicle = "imrc_brushed";
  settings.sensors = {"pose", "gyroscope", "rotor_speed"};
  settings.concealed = R"({type = "motor_lag", time_constant = 0.04})";
  const Diagnosis d = diagnose_saying(test::fly_trial(folder, settings), Hold::unknown);
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_THAT(d.effects[0].classmates, ElementsAre("motor_lag"));
  EXPECT_NEAR(test::value_of(d.effects[0], "time_constant"), 0.04, 0.002);
  EXPECT_TRUE(d.torque_told);
}

// each command is a sample of a loop that jitters: a lag is a better mean of them than none, and as good as a delay
TEST(CommandJitterTrials, LagsAndDelaysThatSpeedsHardlyShowAreAlike) {
  const TemporaryFolder folder;
  test::TrialSettings settings = sampled_loop("pid", 1.0);
  settings.vehicle = "neurobem_racer";
  settings.sensors = {"pose", "gyroscope", "rotor_speed"};
  settings.fit = {"multisine"};
  settings.holdout = {"hover"};
  settings.concealed = R"({type = "actuation_delay", delay = 0.03})";
  const Diagnosis d = diagnose_saying(test::fly_trial(folder, settings), Hold::unknown);
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_THAT(d.effects[0].classmates, UnorderedElementsAre("motor_lag", "actuation_delay"));
}

// the loop of the simulator's own benchmark: the thrust jitters with the torques, and motors rise faster than they fall
TEST(CommandJitterTrials, OfTheThrustLeavesItsMean) {
  const TemporaryFolder folder;
  test::TrialSettings settings = sampled_loop("pid", 2.0);
  settings.fit = {"circle", "lemniscate"};
  settings.holdout = {"multisine"};
  settings.duration_s = 20.0;
  settings.concealed = R"({type = "mass", delta = 0.06})";
  const DiagnoseOptions trial = test::fly_trial(folder, settings);
  const Diagnosis d = diagnose_saying(trial, Hold::unknown);
  EXPECT_THAT(d.not_identifiable, Contains(Field(&NotIdentifiable::why, HasSubstr("thrust jitters"))));
  ASSERT_EQ(d.effects.size(), 1u) << to_json(d).dump(1);
  EXPECT_EQ(d.effects[0].effect, "mass");
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.06, 0.012);
}

TEST(CommandJitterTrials, DoesNotConcernSmoothCommandsWhoseHoldIsUnknown) {
  const TemporaryFolder folder;
  const DiagnoseOptions trial = test::fly_trial(folder, sampled_loop("pid", 0.1));
  const Diagnosis d = diagnose_saying(trial, Hold::unknown);
  EXPECT_NE(d.verdict, Verdict::insufficient_data);
  EXPECT_THAT(finding_kinds(d), IsEmpty()) << to_json(d)["log_findings"].dump();
}

}  // namespace command_jitter_test
}  // namespace gustlab::diagnosis
