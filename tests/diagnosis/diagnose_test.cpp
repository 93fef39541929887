// The whole way from flights to names, on short flights of our own plant: what is planted is found, what is not is not.
#include "diagnosis/diagnose.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "metrics/tracking_error.hpp"
#include "simulation/flight.hpp"
#include "simulation/recorder.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::diagnosis {
namespace diagnose_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* sensors = R"(
[[effect]]
type = "measurement_noise"
position_sd = 0.0005
velocity_sd = 0.01
attitude_sd = 0.002
rate_sd = 0.01
)";

// two different flights to fit and one to hold out, with planted [[effect]] tables
std::vector<std::string> fly_trials(const TemporaryFolder& folder, const std::string& planted) {
  const std::string experiment_path = folder.write("trial.toml", R"(
format = "gustlab-experiment/1"
name = "trial"
vehicle = "crazyflie"
trajectories = ["lemniscate", "multisine", "circle"]
controllers = ["geometric"]
replicates = 1
seed = 7
duration_s = 16.0
step_s = 0.002
[trajectory.circle]
ramp_s = 2.0
period_s = 6.0
[trajectory.lemniscate]
period_s = 6.0
)" + std::string(sensors) + planted);
  const Experiment experiment = read_experiment(experiment_path);
  std::vector<std::string> paths;
  for (const RunSpec& spec : plan(experiment)) {
    Flight flight(experiment, spec);
    FlightRecorder recorder(experiment, flight);
    TrackingError error(0.0, static_cast<std::size_t>(flight.ticks) + 1);
    EXPECT_EQ(fly(flight, error, &recorder).outcome, Outcome::completed);
    FlightLog log = recorder.take();
    // what a real log has, and no more
    std::erase_if(log.columns, [](const LogColumn& c) {
      static const std::vector<std::string> kept = {"px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy",
                                                    "qz", "wx", "wy", "wz", "u1", "u2", "u3", "u4"};
      return std::find(kept.begin(), kept.end(), c.name) == kept.end();
    });
    log.meta.environment = {};
    paths.push_back(folder.file("flight" + std::to_string(paths.size()) + ".csv"));
    write_flight_log(log, paths.back());
  }
  return paths;
}

Diagnosis diagnose_trials(const std::vector<std::string>& paths, int jobs = 2) {
  DiagnoseOptions options;
  options.fit = {paths[0], paths[1]};
  options.holdout = {paths[2]};
  options.jobs = jobs;
  return diagnose(options);
}

std::vector<std::string> names(const Diagnosis& d) {
  std::vector<std::string> result;
  for (const EffectFinding& e : d.effects) result.push_back(e.effect);
  return result;
}

TEST(DiagnoseTrials, NamesNothingWhereNothingIsMissing) {
  const TemporaryFolder folder;
  const Diagnosis d = diagnose_trials(fly_trials(folder, ""));
  EXPECT_THAT(names(d), IsEmpty());
  EXPECT_EQ(to_string(d.verdict), "consistent") << to_json(d).dump(1);
}

// of one flight it was said that effects are tested on other flights
TEST(DiagnoseTrials, SaysOnWhatEffectsAreTested) {
  struct Seen {};
  const TemporaryFolder folder;
  const std::vector<std::string> paths = fly_trials(folder, "");
  DiagnoseOptions options;
  options.fit = {paths[0]};
  std::vector<std::string> stages;
  options.progress = [&](std::string_view stage, std::optional<double> done) {
    stages.emplace_back(stage);
    EXPECT_FALSE(done);  // nobody knows it
    if (stage.starts_with("testing")) throw Seen{};
  };
  EXPECT_THROW(diagnose(options), Seen);
  EXPECT_THAT(stages, ElementsAre("reading the flights", "checking rotors and clocks", "choosing effects",
                                  "testing them on the last third of the flight"));
  options.holdout = {paths[1]};
  EXPECT_THROW(diagnose(options), Seen);
  EXPECT_EQ(stages.back(), "testing them on the held-out flights");
}

TEST(DiagnoseTrials, FindsPlantedRotorDragWithItsTotalValue) {
  const TemporaryFolder folder;
  const auto paths = fly_trials(folder, "[[effect]]\ntype = \"rotor_drag\"\nat_hover = 0.025\n");
  const Diagnosis d = diagnose_trials(paths);
  ASSERT_THAT(names(d), ElementsAre("rotor_drag"));
  EXPECT_NEAR(d.effects[0].parameters[0].value, 0.025, 0.001);
  // and the held-out flight is predicted better with it
  EXPECT_LT(d.fit["position_m"]["after"][1].get<double>(), 0.8 * d.fit["position_m"]["before"][1].get<double>());

  // the same bytes for any number of threads
  EXPECT_EQ(to_json(d).dump(), to_json(diagnose_trials(paths, 1)).dump());
}

TEST(DiagnoseTrials, FindsTheRotorThatLostThrust) {
  const TemporaryFolder folder;
  const Diagnosis d =
      diagnose_trials(fly_trials(folder, "[[effect]]\ntype = \"rotor_loss\"\nrotor = 3\nloss = 0.06\n"));
  ASSERT_THAT(names(d), ElementsAre("rotor_loss"));
  EXPECT_EQ(d.effects[0].parameters[0].value, 3.0);
  EXPECT_NEAR(d.effects[0].parameters[1].value, 0.06, 0.006);
}

TEST(DiagnoseTrials, DoesNotNameAMassWithinCalibration) {
  const TemporaryFolder folder;
  EXPECT_THAT(names(diagnose_trials(fly_trials(folder, "[[effect]]\ntype = \"mass\"\ndelta = 0.006\n"))), IsEmpty());
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

TEST(DiagnoseTrials, GoesOnWithTheRotorOrderThatTheFlightsShow) {
  const TemporaryFolder folder;
  const auto paths = fly_trials(folder, "");
  for (const std::string& path : paths) swap_inputs(path);
  const Diagnosis d = diagnose_trials(paths);
  ASSERT_FALSE(d.log_findings.empty());
  EXPECT_EQ(d.log_findings[0].kind, "inconsistent");
  EXPECT_THAT(d.log_findings[0].says, ::testing::HasSubstr("the file lists as 2, 1, 3, 4"));
  EXPECT_THAT(names(d), IsEmpty());
  // commands are compared with the motion in that order, too
  for (const FlightUse& flight : d.flights) EXPECT_EQ(flight.time_offset_s, 0.0) << flight.file;
}

TEST(DiagnoseTrials, SetsAFlightWithImpossibleInputsAsideAndGoesOn) {
  const TemporaryFolder folder;
  const auto paths = fly_trials(folder, "");
  FlightLog log = read_flight_log(paths[0]);
  for (LogColumn& c : log.columns)
    if (c.name == "u1") c.values[300] = 9e4;
  write_flight_log(log, paths[0]);
  const Diagnosis d = diagnose_trials(paths);
  ASSERT_FALSE(d.log_findings.empty());
  EXPECT_EQ(d.log_findings[0].kind, "out_of_range");
  EXPECT_EQ(d.flights[0].role, "set_aside");
  EXPECT_THAT(names(d), IsEmpty());
}

}  // namespace diagnose_test
}  // namespace gustlab::diagnosis
