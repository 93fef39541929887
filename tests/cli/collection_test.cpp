// From the experiment of the data collection to the model that experiments give to asindy, by the commands alone.
#include <gmock/gmock.h>

#include <filesystem>

#include "config/toml.hpp"
#include "control/residual_model.hpp"
#include "gustlab/flight_log.hpp"
#include "support/program.hpp"

namespace gustlab::test {
namespace collection_test {

namespace fs = std::filesystem;

struct Identified final : Parameterized {
  ResidualModel model;
  void visit(ParameterVisitor& visitor) override { model.visit(visitor); }
};

ResidualModel read_model(const std::string& path) {
  config::Table document = config::Table::read_file(path);
  Identified identified;
  config::read_parameters(config::read_effects(document).at(0), identified);
  identified.model.prepare();
  return identified.model;
}

std::vector<std::string> logs_in(const fs::path& folder, const std::vector<std::string>& variants) {
  std::vector<std::string> logs;
  for (const std::string& variant : variants)
    for (const char* name :
         {"circle_pid_101.csv", "circle_pid_102.csv", "lemniscate_pid_101.csv", "lemniscate_pid_102.csv"})
      logs.push_back((folder / variant / name).string());
  return logs;
}

// GIVEN the experiment that is shipped WHEN it is flown and identified as its head says THEN the model is the shipped one
TEST(Collection, LeadsToTheModelOfAsindy) {
  const TemporaryFolder folder;
  const Said flown = gustlab({"sweep", "collect_iris", "--logs", "--out", folder.file("logs")});
  ASSERT_EQ(flown.exit_code, 0) << flown.err;

  // rows 25 ms apart, between which nobody knows the command
  const std::vector<std::string> logs =
      logs_in(folder.file("logs"), {"calm", "breeze", "north", "west", "quick", "strong"});
  const FlightLog log = read_flight_log(logs[0]);
  ASSERT_EQ(log.rows(), 2400u);
  EXPECT_NEAR(log.time_s[1] - log.time_s[0], 0.025, 1e-9);
  EXPECT_EQ(log.meta.hold, Hold::unknown);

  std::vector<std::string> command{"identify"};
  command.insert(command.end(), logs.begin(), logs.end());
  for (const char* word : {"--known", "thrust", "--smooth", "5", "--trim", "1", "--optimizer", "sr3", "--library",
                           "1,T sin theta,T sin phi", "--out"})
    command.emplace_back(word);
  command.push_back(folder.file("model.toml"));
  const Said identified = gustlab(command);
  ASSERT_EQ(identified.exit_code, 0) << identified.err;

  const ResidualModel found = read_model(folder.file("model.toml"));
  const ResidualModel shipped = read_model((fs::path(source_directory()) / "configs/asindy.toml").string());
  ASSERT_EQ(found.terms().size(), shipped.terms().size());
  for (std::size_t i = 0; i < found.terms().size(); ++i) EXPECT_EQ(found.terms()[i].name(), shipped.terms()[i].name());
  EXPECT_LT((found.coefficients() - shipped.coefficients()).cwiseAbs().maxCoeff(),
            1e-6);  // what the last digits of the simulation may change
}

// the logs are those of the very runs that the table of runs has
TEST(Collection, LogsNothingThatChangesARun) {
  const TemporaryFolder folder;
  const std::vector<std::string> sweep{"sweep", "ci_small", "--set", "replicates=1", "--set", "duration_s=3", "--out"};
  for (const bool logs : {false, true}) {
    std::vector<std::string> command = sweep;
    command.push_back(folder.file(logs ? "with" : "without"));
    if (logs) command.emplace_back("--logs");
    ASSERT_EQ(gustlab(command).exit_code, 0);
  }
  EXPECT_EQ(read_text(folder.file("with/runs.csv")), read_text(folder.file("without/runs.csv")));
  EXPECT_EQ(read_flight_log(folder.file("with/spiral_pid_1.csv")).rows(), 1500u);
  EXPECT_EQ(read_flight_log(folder.file("with/spiral_pid_1.csv")).meta.hold, Hold::zoh);
  EXPECT_FALSE(fs::exists(folder.file("without/spiral_pid_1.csv")));
}

TEST(Variants, AreFlownEachInItsOwnFolderAndCanBeAskedFor) {
  const TemporaryFolder folder;
  const std::string path = folder.write("e.toml", R"(format = "gustlab-experiment/1"
name = "e"
vehicle = "crazyflie"
trajectories = ["hover"]
controllers = ["pid"]
duration_s = 1.0
[[effect]]
type = "gust"
sigma_xy = 0.03
[[variant]]
name = "calm"
set = ["effect.gust.sigma_xy = 0"]
[[variant]]
name = "short"
set = ["duration_s = 0.5"]
)");
  ASSERT_EQ(gustlab({"sweep", path, "--out", folder.file("o")}).exit_code, 0);
  EXPECT_THAT(read_text(folder.file("o/calm/runs.csv")),
              testing::HasSubstr("\ne.calm,crazyflie,hover,pid,1,completed,1,"));
  EXPECT_THAT(read_text(folder.file("o/short/runs.csv")),
              testing::HasSubstr("\ne.short,crazyflie,hover,pid,1,completed,0.5,"));
  EXPECT_THAT(gustlab({"sweep", path, "--dry-run"}).out,
              testing::StartsWith("variant,trajectory,controller,replicate,key\ncalm,hover,pid,1,"));
  EXPECT_EQ(gustlab({"run", path, "--variant", "short", "--trajectory", "hover", "--controller", "pid", "--out",
                     folder.file("r")})
                .exit_code,
            0);
  EXPECT_THAT(read_text(folder.file("r/outcome.json")), testing::HasSubstr("\"duration_s\": 0.5"));

  const Said unknown = gustlab(
      {"run", path, "--variant", "shrt", "--trajectory", "hover", "--controller", "pid", "--out", folder.file("x")});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err,
              testing::HasSubstr("there is no variant \"shrt\" (it has calm, short); did you mean \"short\"?"));
  const Said twice = gustlab(
      {"sweep", folder.write("t.toml", read_text(path) + "[[variant]]\nname = \"calm\"\n"), "--out", folder.file("y")});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_THAT(twice.err, testing::HasSubstr("t.toml:17:8: variant \"calm\" is here twice"));
  EXPECT_FALSE(fs::exists(folder.file("y")));
}

}  // namespace collection_test
}  // namespace gustlab::test
