#include "simulation/experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "gustlab/errors.hpp"
#include "support/experiments.hpp"

namespace gustlab {
namespace {

using test::read_text_experiment;
using test::small_experiment;
using testing::HasSubstr;

std::string message_for(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    read_text_experiment(text, overrides);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

std::set<std::string> keys_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  std::set<std::string> keys;
  for (const RunSpec& spec : plan(read_text_experiment(text, overrides))) keys.insert(to_hex(spec.key));
  return keys;
}

TEST(Experiment, PlanGoesByTrajectoryThenControllerThenReplicate) {
  const Experiment experiment = read_text_experiment(small_experiment, {"controllers=[\"pid\", \"geometric\"]", "first_replicate=5"});
  const auto runs = plan(experiment);
  ASSERT_EQ(runs.size(), 12u);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(runs[i].index, i);
    EXPECT_EQ(runs[i].trajectory, i / 6);
    EXPECT_EQ(runs[i].controller, i / 3 % 2);
    EXPECT_EQ(runs[i].replicate, 5 + i % 3);
  }
}

TEST(Experiment, KeysAreDistinctAndOnlyWhatChangesAResultChangesThem) {
  const auto keys = keys_of(small_experiment);
  EXPECT_EQ(keys.size(), 6u);
  EXPECT_EQ(keys_of(small_experiment, {"log_rate_hz=50", "name=other"}), keys);
  // a further trajectory keeps the keys that were there
  const auto more = keys_of(small_experiment, {"trajectories=[\"spiral\", \"circle\", \"hover\"]"});
  EXPECT_TRUE(std::includes(more.begin(), more.end(), keys.begin(), keys.end()));
  EXPECT_EQ(more.size(), 9u);
  for (const char* change : {"seed=2", "duration_s=1.1", "step_s=0.001", "settle_s=0.1", "environment.ground_z_m=-1.0",
                             "offboard_rate_hz=50", "max_error_m=99", "vehicle=crazyflie_real"}) {
    const auto changed = keys_of(small_experiment, {change});
    for (const std::string& key : keys) EXPECT_EQ(changed.count(key), 0u) << change;
  }
}

TEST(Experiment, ParametersGoToTheirOwnTrajectoryAndController) {
  const auto keys = keys_of(small_experiment), changed = keys_of(small_experiment, {"trajectory.circle.radius_m=0.5"});
  std::vector<std::string> same;
  std::set_intersection(keys.begin(), keys.end(), changed.begin(), changed.end(), std::back_inserter(same));
  EXPECT_EQ(same.size(), 3u);  // hover's
}

TEST(Experiment, OneTypeFliesUnderSeveralNames) {
  const Experiment experiment = read_text_experiment(small_experiment + "[controller.soft]\ntype = \"pid\"\nposition_gain = 0.5\n",
                                                     {"controllers=[\"pid\", \"soft\"]"});
  EXPECT_EQ(experiment.controllers[1].name, "soft");
  EXPECT_EQ(experiment.controllers[1].spec.type, "pid");
  EXPECT_EQ(plan(experiment).size(), 12u);
}

TEST(Experiment, EffectsOfTheVehicleAreReplacedByIncludedOnesAndThoseByItsOwn) {
  const TemporaryFolder folder;
  folder.write("more.toml", "[[effect]]\ntype = \"motor_lag\"\ntime_constant = 0.05\n[[effect]]\ntype = \"mass\"\ndelta = 0.1\n");
  const std::string path = folder.write("experiment.toml", "include = [\"more.toml\"]\n" + small_experiment + "[[effect]]\ntype = \"mass\"\ndelta = 0.2\n");
  const Experiment experiment = read_experiment(path);
  std::vector<std::string> types;
  for (const EffectSpec& spec : experiment.effects) {
    types.push_back(spec.type);
    const std::string first = spec.values.front().second;
    EXPECT_TRUE(spec.type != "motor_lag" || first == "0.05") << first;
    EXPECT_TRUE(spec.type != "mass" || first == "0.2") << first;
  }
  EXPECT_THAT(types, testing::UnorderedElementsAre("motor_lag", "rotor_drag", "mass", "gust"));
  // what a controller knows stays the nominal vehicle
  EXPECT_EQ(experiment.vehicle.effects.size(), 2u);
}

struct Mistake {
  const char* says;
  const char* from;
  const char* to;
  const char* message;
};

class ExperimentMistake : public testing::TestWithParam<Mistake> {};

TEST_P(ExperimentMistake, IsReportedWithItsPlace) {
  std::string text = small_experiment;
  const std::size_t place = text.find(GetParam().from);
  ASSERT_NE(place, std::string::npos);
  text.replace(place, std::string(GetParam().from).size(), GetParam().to);
  EXPECT_THAT(message_for(text), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, ExperimentMistake,
    testing::Values(
        Mistake{"format", "experiment/1", "experiment/7", "experiment.toml:2:10: not an experiment of this program"},
        Mistake{"name", "\"small\"", "\"a,b\"", "experiment.toml:3:8: \"a,b\" is no name"},
        Mistake{"vehicle", "\"crazyflie\"", "\"crazyfly\"", "did you mean \"crazyflie\"?"},
        Mistake{"trajectory", "\"circle\", ", "\"circel\", ", "experiment.toml:5:16: unknown trajectory \"circel\" did you mean \"circle\"?"},
        Mistake{"twice", "\"circle\", \"hover\"", "\"hover\", \"hover\"", "experiment.toml:5:16: \"hover\" is here twice"},
        Mistake{"none", "[\"circle\", \"hover\"]", "[]", "experiment.toml:5:16: \"trajectories\" is empty"},
        Mistake{"controller", "\"pid\"", "\"pdi\"", "unknown controller \"pdi\" did you mean \"pid\"?"},
        Mistake{"replicates", "replicates = 3", "replicates = 0", "experiment.toml:7:14: \"replicates\" is out of range"},
        Mistake{"type", "replicates = 3", "replicates = \"3\"", "experiment.toml:7:14: \"replicates\" must be"},
        Mistake{"key", "duration_s", "durations", "experiment.toml:8:1: unknown key \"durations\" did you mean \"duration_s\"?"},
        Mistake{"endless", "duration_s = 1.0", "", "experiment.toml:1:1: trajectory \"circle\" has no natural end"},
        Mistake{"choice of a trajectory", "start = \"reference\"", "start = \"middle\"", "experiment.toml:13:9: start = \"middle\" is unknown"},
        Mistake{"rate of a controller", "[trajectory", "[controller.pid]\nrate_hz = 333\n[trajectory",
                "experiment.toml:12:11: rate_hz = 333 does not divide the base rate of 500 Hz"},
        Mistake{"loops of a controller", "[trajectory", "[controller.pid]\nlow_level = \"px4\"\n[trajectory",
                "experiment.toml:12:13: low_level = \"px4\" is unknown"},
        Mistake{"rotor of an effect", "[trajectory", "[[effect]]\ntype = \"rotor_loss\"\nrotor = 5\n[trajectory",
                "experiment.toml:13:9: rotor_loss: no rotor 5"},
        Mistake{"step", "duration_s = 1.0", "duration_s = 1.0\nstep_s = 0.003", "experiment.toml:9:10: \"step_s\" 0.003 s does not divide the period"},
        Mistake{"offboard", "duration_s = 1.0", "duration_s = 1.0\noffboard_rate_hz = 300",
                "experiment.toml:9:20: the period of controller \"pid\", 0.002 s does not divide"},
        Mistake{"settle", "duration_s = 1.0", "duration_s = 1.0\nsettle_s = 1.0", "experiment.toml:9:12: \"settle_s\" leaves nothing to measure"},
        Mistake{"source", "duration_s = 1.0", "duration_s = 1.0\nlog_source = \"mind\"", "\"mind\" is no source"},
        Mistake{"include", "duration_s = 1.0", "duration_s = 1.0\ninclude = [\"nowhere.toml\"]", "nowhere.toml: cannot read"},
        Mistake{"parameter", "period_s = 5.0", "perod_s = 5.0", "experiment.toml:12:11: unknown key \"perod_s\" did you mean \"period_s\"?"},
        Mistake{"range", "period_s = 5.0", "period_s = -5.0", "experiment.toml:12:12: \"period_s\" is out of range"},
        Mistake{"unused", "[trajectory.circle]", "[trajectory.circel]", "unknown trajectory \"circel\""},
        Mistake{"effect", "\"gust\"", "\"gusts\"", "unknown effect \"gusts\" did you mean \"gust\"?"},
        Mistake{"effect key", "sigma_xy", "sigma_yx", "unknown key \"sigma_yx\" did you mean \"sigma_xy\"?"},
        Mistake{"syntax", "name = ", "name ", "experiment.toml:3:"}),
    [](const auto& one) {
      std::string name = one.param.says;
      for (char& c : name)
        if (c == ' ') c = '_';
      return name;
    });

// GIVEN a variant that sets what there is not WHEN it is read THEN the place is the variant's, and that of --set is the command line
TEST(Variants, SayWhereTheySetWhatThereIsNot) {
  const TemporaryFolder folder;
  const std::string variant = "[[variant]]\nname = \"v\"\nset = [\"seed=2\", \"controller.pid.rate_hz=333\"]\n";
  const std::string path = folder.write("e.toml", small_experiment + variant);
  const auto message = [&](const std::string& override_text) -> std::string {
    try {
      read_variants(path, {override_text});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("seed=3"), HasSubstr("e.toml:20:7: rate_hz = 333 does not divide"));
  EXPECT_THAT(message("controller.pid.rate_hz=7"), testing::StartsWith("--set controller.pid.rate_hz=7: rate_hz = 7 does not divide"));
  EXPECT_EQ(message("controller.pid.rate_hz=100"), "");
}

TEST(Experiment, NameUnderExperimentsIsFoundFromAnywhere) {
  EXPECT_THAT(find_experiment("table2_crazyflie"), testing::EndsWith("experiments/table2_crazyflie.toml"));
  EXPECT_THROW(find_experiment("table9"), ConfigError);
}

}  // namespace
}  // namespace gustlab
