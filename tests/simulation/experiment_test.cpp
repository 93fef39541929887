#include "simulation/experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "gustlab/errors.hpp"
#include "support/experiments.hpp"

namespace gustlab {
namespace experiment_test {

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
  const Experiment experiment =
      read_text_experiment(small_experiment, {"controllers=[\"pid\", \"geometric\"]", "first_replicate=5"});
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
  const Experiment experiment =
      read_text_experiment(small_experiment + "[controller.soft]\ntype = \"pid\"\nposition_gain = 0.5\n",
                           {"controllers=[\"pid\", \"soft\"]"});
  EXPECT_EQ(experiment.controllers[1].name, "soft");
  EXPECT_EQ(experiment.controllers[1].spec.type, "pid");
  EXPECT_EQ(plan(experiment).size(), 12u);
}

TEST(Experiment, EffectsOfTheVehicleAreReplacedByIncludedOnesAndThoseByItsOwn) {
  const TemporaryFolder folder;
  folder.write("more.toml",
               "[[effect]]\ntype = \"motor_lag\"\ntime_constant = 0.05\n[[effect]]\ntype = \"mass\"\ndelta = 0.1\n");
  const std::string path = folder.write("experiment.toml", "include = [\"more.toml\"]\n" + small_experiment +
                                                               "[[effect]]\ntype = \"mass\"\ndelta = 0.2\n");
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

TEST(Experiment, FileOfAnIncludedControllerIsBesideTheIncludedFileWhoeverListsTheControllers) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "gains");
  folder.write("gains/model.toml",
               "[[effect]]\ntype = \"sindy_residual\"\nterms = [\"1\"]\nfx = [0.0]\nfy = [0.0]\nfz = [0.0]\n");
  folder.write("gains/adaptive.toml", "[controller.asindy]\nmodel = \"model.toml\"\n");
  const std::string path = folder.write("experiment.toml", "include = [\"gains/adaptive.toml\"]\n" + small_experiment);
  EXPECT_EQ(read_experiment(path, {"controllers=[\"asindy\"]"}).controllers.front().name, "asindy");
  EXPECT_EQ(read_experiment(path, {"controllers=asindy", "controller.asindy.rate_hz=100"}).controllers.size(), 1u);
}

TEST(Experiment, LogsAtTheRatesThatItsMessagesName) {
  for (const char* rate : {"27.7777777778", "29.4117647059", "27.77777777777778", "250", "500", "2"})
    EXPECT_EQ(message_for(small_experiment, {std::string("log_rate_hz=") + rate}), "") << rate;
  // a loop of 400 Hz
  EXPECT_EQ(message_for(small_experiment, {"vehicle=iris", "step_s=0.0025", "log_rate_hz=80"}), "");
  EXPECT_THAT(message_for(small_experiment, {"vehicle=iris", "step_s=0.0025", "log_rate_hz=250"}),
              HasSubstr("--set log_rate_hz=250: \"log_rate_hz\" 250 Hz does not divide the rate of controller \"pid\", "
                        "400 Hz (steps between rows would be unequal); write log_rate_hz = 200 or 400"));
}

// the hovers are flown too
TEST(Experiment, HandsOverWithinTheWholeFlight) {
  EXPECT_EQ(message_for(small_experiment, {"hand_over_s=1.5", "hover_before_s=1"}), "");
  EXPECT_THAT(message_for(small_experiment, {"hand_over_s=100"}),
              HasSubstr("--set hand_over_s=100: \"hand_over_s\" leaves"));
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
        Mistake{"trajectory", "\"circle\", ", "\"circel\", ",
                "experiment.toml:5:16: unknown trajectory \"circel\"; did you mean \"circle\"?"},
        Mistake{"twice", "\"circle\", \"hover\"", "\"hover\", \"hover\"",
                "experiment.toml:5:16: \"hover\" is here twice"},
        Mistake{"none", "[\"circle\", \"hover\"]", "[]", "experiment.toml:5:16: \"trajectories\" is empty"},
        Mistake{"controller", "\"pid\"", "\"pdi\"", "unknown controller \"pdi\"; did you mean \"pid\"?"},
        Mistake{"replicates", "replicates = 3", "replicates = 0",
                "experiment.toml:7:14: \"replicates\" is out of range"},
        Mistake{"type", "replicates = 3", "replicates = \"3\"", "experiment.toml:7:14: \"replicates\" must be"},
        Mistake{"key", "duration_s", "durations",
                "experiment.toml:8:1: unknown key \"durations\"; did you mean \"duration_s\"?"},
        Mistake{"endless", "duration_s = 1.0", "", "experiment.toml:1:1: trajectory \"circle\" has no natural end"},
        Mistake{"choice of a trajectory", "start = \"reference\"", "start = \"middle\"",
                "experiment.toml:13:9: start = \"middle\" is unknown"},
        Mistake{"rate of a controller", "[trajectory", "[controller.pid]\nrate_hz = 333\n[trajectory",
                "experiment.toml:12:11: rate_hz = 333 does not divide the base rate of 500 Hz"},
        Mistake{"loops of a controller", "[trajectory", "[controller.pid]\nlow_level = \"px4\"\n[trajectory",
                "experiment.toml:12:13: low_level = \"px4\" is unknown"},
        Mistake{"rotor of an effect", "[trajectory", "[[effect]]\ntype = \"rotor_loss\"\nrotor = 5\n[trajectory",
                "experiment.toml:13:9: rotor_loss: no rotor 5"},
        Mistake{"step", "duration_s = 1.0", "duration_s = 1.0\nstep_s = 0.003",
                "experiment.toml:9:10: \"step_s\" 0.003 s does not divide the period of controller \"pid\", 0.002 s; "
                "write step_s = 0.002"},
        Mistake{"offboard", "duration_s = 1.0", "duration_s = 1.0\noffboard_rate_hz = 300",
                "experiment.toml:9:20: the period of controller \"pid\", 0.002 s does not divide"},
        Mistake{"log slower", "duration_s = 1.0", "duration_s = 1.0\nlog_rate_hz = 333",
                "experiment.toml:9:15: \"log_rate_hz\" 333 Hz does not divide the rate of controller \"pid\", 500 Hz "
                "(steps "
                "between rows would be unequal); write log_rate_hz = 250 or 500"},
        Mistake{"log slower still", "duration_s = 1.0", "duration_s = 1.0\nlog_rate_hz = 28",
                "28 Hz does not divide the rate of controller \"pid\", 500 Hz (steps between rows would be unequal); "
                "write log_rate_hz = 27.7777777778 or 29.4117647059"},
        Mistake{
            "log faster", "duration_s = 1.0", "duration_s = 1.0\nlog_rate_hz = 700",
            "experiment.toml:9:15: \"log_rate_hz\" 700 Hz is above the rate of controller \"pid\", 500 Hz (it has no "
            "more rows); write log_rate_hz = 500"},
        Mistake{"log of one row", "duration_s = 1.0", "duration_s = 1.0\nlog_rate_hz = 1",
                "experiment.toml:9:15: \"log_rate_hz\" 1 Hz leaves one row of a flight of 1 s"},
        Mistake{"hand over", "duration_s = 1.0", "duration_s = 1.0\nhand_over_s = 1.0",
                "experiment.toml:9:15: \"hand_over_s\" leaves nothing to fly for controller \"pid\" (it is not shorter "
                "than "
                "the flight, 1 s)"},
        Mistake{"settle", "duration_s = 1.0", "duration_s = 1.0\nsettle_s = 1.0",
                "experiment.toml:9:12: \"settle_s\" leaves nothing to measure"},
        Mistake{"source", "duration_s = 1.0", "duration_s = 1.0\nlog_source = \"mind\"", "\"mind\" is no source"},
        Mistake{"include", "duration_s = 1.0", "duration_s = 1.0\ninclude = [\"nowhere.toml\"]",
                "nowhere.toml\" cannot be read"},
        Mistake{"parameter", "period_s = 5.0", "perod_s = 5.0",
                "experiment.toml:12:11: unknown key \"perod_s\"; did you mean \"period_s\"?"},
        Mistake{"range", "period_s = 5.0", "period_s = -5.0", "experiment.toml:12:12: \"period_s\" is out of range"},
        Mistake{"unused", "[trajectory.circle]", "[trajectory.circel]", "unknown trajectory \"circel\""},
        Mistake{"effect", "\"gust\"", "\"gusts\"", "unknown effect \"gusts\"; did you mean \"gust\"?"},
        Mistake{"effect key", "sigma_xy", "sigma_yx", "unknown key \"sigma_yx\"; did you mean \"sigma_xy\"?"},
        Mistake{"syntax", "name = ", "name ", "experiment.toml:3:"}),
    [](const auto& one) {
      std::string name = one.param.says;
      for (char& c : name)
        if (c == ' ') c = '_';
      return name;
    });

class Variants : public testing::Test {
 protected:
  std::vector<Experiment> read(const std::string& tables, const std::vector<std::string>& overrides = {},
                               const std::vector<std::string>& only = {}) {
    return read_variants(folder_.write("e.toml", small_experiment + tables), overrides, only);
  }
  std::string message(const std::string& tables, const std::vector<std::string>& overrides = {},
                      const std::vector<std::string>& only = {}) {
    try {
      read(tables, overrides, only);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

// GIVEN a variant that sets what there is not WHEN it is read THEN the place is the variant's
TEST_F(Variants, SayWhereTheySetWhatThereIsNot) {
  EXPECT_THAT(message("[[variant]]\nname = \"v\"\nset = [\"seed=2\", \"controller.pid.rate_hz=333\"]\n"),
              HasSubstr("e.toml:20:7: rate_hz = 333 does not divide"));
}

// GIVEN an override of what a variant sets WHEN they are read THEN it is refused: the variants would be alike
TEST_F(Variants, AreNotLostToAnOverride) {
  const std::string tables =
      "[[variant]]\nname = \"strong\"\nset = [\"effect.gust={sigma_xy=0.06}\"]\n[[variant]]\nname = \"calm\"\nset = "
      "[\"effect.gust.strength=0\"]\n";
  EXPECT_THAT(message(tables, {"effect.gust.sigma_xy=0.01"}),
              HasSubstr("--set effect.gust.sigma_xy=0.01: variant \"strong\" sets effect.gust.sigma_xy itself"));
  EXPECT_THAT(message(tables, {"effect.gust={strength=2}"}),
              HasSubstr("variant \"calm\" sets effect.gust.strength itself"));
  EXPECT_EQ(message(tables, {"effect.gust.sigma_xy=0.01"}, {"calm"}), "");
  EXPECT_EQ(message(tables, {"effect.gust.sigma_z=0.01", "seed=3"}), "");
}

// GIVEN two axes WHEN they are read THEN they span a grid, the last one fastest, and each point says where it stands
TEST_F(Variants, AxesSpanAGrid) {
  const auto grid = read(
      "[[axis]]\nkey = \"effect.gust.strength\"\nvalues = [0.5, 1.0]\n[[axis]]\nname = \"rate\"\nkeys = "
      "[\"offboard_rate_hz\", \"controller.pid.rate_hz\"]\nvalues = [50, 100, 250]\n");
  ASSERT_EQ(grid.size(), 6u);
  EXPECT_EQ(grid[0].name, "small.strength_0.5_rate_50");
  EXPECT_EQ(grid[4].variant, "strength_1_rate_100");
  EXPECT_EQ(grid[4].axes, (std::vector<NamedValue>{{"strength", "1"}, {"rate", "100"}}));
  EXPECT_EQ(grid[4].axis_units, (std::vector<NamedValue>{{"strength", "-"}, {"rate", "Hz"}}));
  EXPECT_EQ(grid[5].flight.offboard_rate_hz, 250.0);
  std::set<std::string> keys;
  for (const Experiment& point : grid) keys.insert(to_hex(plan(point).front().key));
  EXPECT_EQ(keys.size(), 6u);
  EXPECT_EQ(read("[[axis]]\nkey = \"seed\"\nvalues = [1, 2, 3]\n", {}, {"seed_2"}).front().seed, 2);
}

TEST_F(Variants, AxesAreZippedRowByRowAndCrossedWithVariants) {
  const std::string axis = "[[axis]]\nkeys = [\"seed\", \"settle_s\"]\nvalues = [[1, 0.0], [2, 0.5]]\n";
  const auto grid = read(axis + "[[variant]]\nname = \"a\"\nset = [\"replicates=1\"]\n[[variant]]\nname = \"b\"\n");
  ASSERT_EQ(grid.size(), 4u);
  EXPECT_EQ(grid[1].variant, "a_seed_2");
  EXPECT_EQ(grid[1].flight.settle_s, 0.5);
  EXPECT_EQ(grid[1].replicates, 1);
  EXPECT_EQ(grid[3].axes, (std::vector<NamedValue>{{"variant", "b"}, {"seed", "2"}}));
}

// GIVEN axes that are alone WHEN they are read THEN each point is a variant beside the others, which changes nothing else
TEST_F(Variants, AxesThatAreAloneAreNotCrossed) {
  const auto all = read(
      "[[variant]]\nname = \"nominal\"\n[[axis]]\nkey = \"seed\"\nvalues = [4, 5]\nalone = true\n[[axis]]\nname = "
      "\"late\"\nkey = \"offboard_delay_s\"\nvalues = [0.1]\nalone = true\n");
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].alone, NamedValue{});
  EXPECT_EQ(all[1].variant, "seed_4");
  EXPECT_EQ(all[1].axes, (std::vector<NamedValue>{{"variant", "seed_4"}}));
  EXPECT_EQ(all[2].seed, 5);
  EXPECT_EQ(all[2].flight.offboard_delay_s, 0.0);
  EXPECT_EQ(all[3].seed, 1);
  EXPECT_EQ(all[3].alone, (NamedValue{"late", "0.1"}));
}

TEST_F(Variants, SayWhatIsWrongWithAnAxis) {
  for (const auto& [table, says] : std::vector<std::pair<std::string, std::string>>{
           {"[[axis]]\nvalues = [1]\n", "e.toml:18:1: an axis needs \"key\" or \"keys\""},
           {"[[axis]]\nkey = \"seed\"\n", "\"values\" is missing or empty"},
           {"[[axis]]\nkey = \"seed\"\nvalues = [1, 1]\n", "e.toml:20:10: \"1\" is here twice"},
           {"[[axis]]\nkey = \"sead\"\nvalues = [1]\n", "e.toml:20:10: unknown key \"sead\"; did you mean \"seed\"?"},
           {"[[axis]]\nkeys = [\"seed\", \"settle_s\"]\nvalues = [[1, 2, 3]]\n", "has 3 values for 2 keys"},
           {"[[axis]]\nkey = \"seed\"\nvalues = [1]\n[[axis]]\nkey = \"seed\"\nvalues = [2]\n",
            "axis \"seed\" is here twice"},
           {"[[axis]]\nkey = \"seed\"\nvalues = [1]\n[[axis]]\nkey = \"settle_s\"\nvalues = [0.5]\nalone = true\n",
            "axes that are alone stand beside crossed ones"},
           {"[[variant]]\nname = \"seed_1\"\n[[axis]]\nkey = \"seed\"\nvalues = [1]\nalone = true\n",
            "variant \"seed_1\" is here twice"},
           {"[[variant]]\nname = \"a\"\nset = [\"seed=7\"]\n[[axis]]\nname = \"s\"\nkey = \"seed\"\nvalues = [1]\n",
            "e.toml:23:7: axis \"s\" sets seed anew (the value of a at "},
           {"[[variant]]\nname = \"a\"\nset = [\"effect.gust={strength=2}\"]\n[[axis]]\nkeys = [\"settle_s\", "
            "\"effect.gust.strength\"]\nvalues = [0.5]\n",
            "e.toml:22:8: axis \"settle_s\" sets effect.gust.strength anew (the value of a at "},
           {"[[axis]]\nkey = \"seed\"\nvalues = [1]\n[[axis]]\nname = \"s\"\nkey = \"seed\"\nvalues = [2]\n",
            "e.toml:23:7: axis \"s\" sets seed anew (the value of seed_1 at "},
           {"[[variant]]\nname = \"a\"\nset = [\"seed=7\", \"settle_s=1\", \"seed=8\"]\n",
            "e.toml:20:7: seed is set twice (its first value would be lost); keep one"},
           {"[[axis]]\nkeys = [\"seed\", \"seed\"]\nvalues = [[1, 2]]\n", "e.toml:19:8: seed is set twice"},
           {"[[variant]]\nname = \"a\"\nset = [\"seed\"]\n[[axis]]\nkey = \"seed\"\nvalues = [1]\n",
            "e.toml:20:7: not an override"}})
    EXPECT_THAT(message(table), HasSubstr(says));
  EXPECT_THAT(message("[[variant]]\nname = \"calm\"\n", {}, {"clam"}),
              HasSubstr("there is no variant \"clam\" (it has calm); did you mean \"calm\"?"));
}

TEST(Experiment, ListsMayBeSetAsWords) {
  EXPECT_EQ(read_text_experiment(small_experiment, {"controllers=pid, geometric"}).controllers.size(), 2u);
  EXPECT_THAT(message_for(small_experiment, {"controllers=pid,ASINDy"}),
              HasSubstr("unknown controller \"ASINDy\"; did you mean \"asindy\"?"));
  EXPECT_THAT(message_for(small_experiment, {"trajectories=infinity"}),
              HasSubstr("unknown trajectory \"infinity\"; did you mean \"lemniscate\"?"));
}

TEST(Experiment, NameUnderExperimentsIsFoundFromAnywhere) {
  EXPECT_THAT(find_experiment("table2_crazyflie"), testing::EndsWith("experiments/table2_crazyflie.toml"));
  EXPECT_THROW(find_experiment("table9"), ConfigError);
}

}  // namespace experiment_test
}  // namespace gustlab
