// Tuning: the same budget for every controller, gusts of its own, and the same values for any number of threads.
#include "sweep/tune.hpp"

#include <gmock/gmock.h>

#include "gustlab/errors.hpp"
#include "support/experiments.hpp"

namespace gustlab::test {
namespace tune_test {

const std::string tuning_text = R"(
format = "gustlab-tuning/1"
flights = 24
replicates = 1
[[controller]]
name = "pid"
parameters = [{ name = "position_gain", min = 0.1, max = 4.0, start = 0.3, log = true },
              { name = "velocity_gain", min = 0.3, max = 2.0, start = 0.5 }]
[[controller]]
name = "geometric"
parameters = [{ name = "bandwidth_radps", min = 0.3, max = 4.0, start = 0.5, log = true }]
)";

class Tune : public testing::Test {
 protected:
  std::vector<TuneResult> tuned(int jobs) const {
    const std::atomic<bool> stop{false};
    return tune(experiment_, {}, read_tuning(tuning_), jobs, stop,
                [](std::size_t done, std::size_t all) { EXPECT_LE(done, all); });
  }

  TemporaryFolder folder_;
  static std::string with_both() {
    std::string text = small_experiment;
    const std::string list = "controllers = [\"pid\"";
    return text.insert(text.find(list) + list.size(), ", \"geometric\"");
  }
  std::string experiment_ = folder_.write("e.toml", with_both());
  std::string tuning_ = folder_.write("e.tuning.toml", tuning_text);
};

TEST_F(Tune, ImprovesEveryControllerWithinItsBudget) {
  const std::vector<TuneResult> results = tuned(1);
  ASSERT_EQ(results.size(), 2u);
  for (const TuneResult& result : results) {
    EXPECT_LT(result.loss, 0.9 * result.start_loss) << result.controller;
    EXPECT_LE(result.flights, 24) << result.controller;
    EXPECT_GE(result.flights, 16) << result.controller;
  }
}

// GIVEN three searches and two scenarios WHEN tuning THEN the best search counts, every one is told, and every scenario is paid for
TEST_F(Tune, SearchesFromSeveralSeedsOverScenarios) {
  Tuning tuning =
      read_tuning(folder_.write("s.toml", "search_seeds = [1, 2, 3]\n" + tuning_text +
                                              "[[scenario]]\n[[scenario]]\nset = [\"offboard_delay_s=0.05\"]\n"));
  ASSERT_EQ(tuning.scenarios.size(), 2u);
  tuning.controllers.resize(1);
  const std::atomic<bool> stop{false};
  const TuneResult result = tune(experiment_, {}, tuning, 2, stop, [](std::size_t, std::size_t) {}).front();
  ASSERT_EQ(result.seed_losses.size(), 3u);
  EXPECT_EQ(result.loss, *std::min_element(result.seed_losses.begin(), result.seed_losses.end()));
  EXPECT_EQ(result.flights % 4, 0);
  EXPECT_THAT(
      to_toml({result}, tuning, "e"),
      testing::HasSubstr("3 searches of at most 24 flights per controller, replicates 1001 to 1001, 2 scenarios"));
}

TEST_F(Tune, FindsTheSameForAnyNumberOfThreads) {
  const Tuning tuning = read_tuning(tuning_);
  EXPECT_EQ(to_toml(tuned(1), tuning, "e"), to_toml(tuned(3), tuning, "e"));
}

// GIVEN tuned gains WHEN an experiment includes them THEN they hold, and what it says itself holds above them
TEST_F(Tune, WritesWhatAnExperimentCanInclude) {
  const std::string gains = to_toml(tuned(2), read_tuning(tuning_), "e");
  folder_.write("gains.toml", gains + "[controller.other]\ntype = \"geometric\"\nbandwidth_radps = 2.0\n");
  const auto keys = [&](const std::string& more) {
    std::string text = small_experiment;
    text.replace(text.find("[environment]"), 0, "include = [\"gains.toml\"]\n");
    return resolved_text(
        read_experiment(folder_.write("included.toml", text), {"controllers=[\"pid\",\"other\"]", more}));
  };
  const std::string gain = gains.substr(gains.find("position_gain"),
                                        gains.find('\n', gains.find("position_gain")) - gains.find("position_gain"));
  EXPECT_THAT(keys("seed=1"), testing::HasSubstr(gain + "\n"));
  EXPECT_THAT(keys("seed=1"), testing::HasSubstr("[controller.other]\ntype = \"geometric\""));
  EXPECT_THAT(keys("seed=1"), testing::HasSubstr("bandwidth_radps = 2\n"));
  EXPECT_THAT(keys("controller.pid.position_gain=3.5"), testing::HasSubstr("position_gain = 3.5\n"));
}

TEST_F(Tune, RefusesSeedsThatAreReported) {
  const std::atomic<bool> stop{false};
  Tuning tuning = read_tuning(tuning_);
  const auto message = [&](const std::vector<std::string>& overrides) {
    return [&, overrides] { tune(experiment_, overrides, tuning, 1, stop, [](std::size_t, std::size_t) {}); };
  };
  EXPECT_THAT(message({"first_replicate=1000"}), testing::ThrowsMessage<ConfigError>(testing::HasSubstr(
                                                     "tunes on replicates 1001 to 1001, which are those of small")));
  tuning.first_replicate = 10;
  EXPECT_THAT(message({"first_replicate=50"}),
              testing::ThrowsMessage<ConfigError>(testing::HasSubstr("which are the tables'")));
}

// GIVEN a file that asks for what the experiment has not WHEN tuning THEN it says where, before anything flies
TEST_F(Tune, SaysWhereItsFileDoesNotFitTheExperiment) {
  const auto message = [&](const std::string& from, const std::string& to) -> std::string {
    std::string text = tuning_text;
    text.replace(text.rfind(from), from.size(), to);
    const std::atomic<bool> stop{true};
    try {
      tune(experiment_, {}, read_tuning(folder_.write("w.toml", text)), 1, stop,
           [](std::size_t, std::size_t) { ADD_FAILURE() << "flew"; });
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "flew";
  };
  EXPECT_THAT(message("geometric", "geometrik"),
              testing::HasSubstr("w.toml:10:8: unknown controller \"geometrik\"; did you mean \"geometric\"?"));
  EXPECT_THAT(message("bandwidth_radps", "bandwidth"),
              testing::HasSubstr("w.toml:11:24: unknown key \"bandwidth\"; did you mean"));
  EXPECT_THAT(
      message("flights = 24", "flights = 1"),
      testing::HasSubstr("w.toml:3:11: a budget of 1 flights does not pay for one evaluation of pid (2 flights"));
}

// GIVEN a file with a controller that the experiment does not list WHEN tuning THEN it is refused: its gains would be of another experiment
TEST_F(Tune, TunesNoControllerThatTheExperimentDoesNotList) {
  const std::atomic<bool> stop{false};
  EXPECT_THAT(
      [&] {
        tune(experiment_, {"controllers=pid"}, read_tuning(tuning_), 1, stop,
             [](std::size_t, std::size_t) { ADD_FAILURE() << "flew"; });
      },
      testing::ThrowsMessage<ConfigError>(testing::HasSubstr(
          "e.tuning.toml:10:8: \"geometric\" is none of the controllers of the experiment (it has pid); add it")));
}

TEST_F(Tune, SaysWhereItsFileIsWrong) {
  const auto message = [&](const std::string& from, const std::string& to) -> std::string {
    std::string text = tuning_text;
    text.replace(text.find(from), from.size(), to);
    try {
      read_tuning(folder_.write("w.toml", text));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message("start = 0.3", "start = 5.0"),
              testing::HasSubstr("w.toml:7:71: \"min\", \"start\" and \"max\" are out of order"));
  EXPECT_THAT(message("min = 0.1", "min = 0.0"), testing::HasSubstr("\"min\" has no logarithm"));
  EXPECT_THAT(message("flights = 24", "flights = 0"), testing::HasSubstr("w.toml:3:11: \"flights\" is not positive"));
  EXPECT_THAT(message("flights", "flight"),
              testing::HasSubstr("w.toml:3:1: unknown key \"flight\"; did you mean \"flights\"?"));
  EXPECT_THAT(message("flights = 24\n", ""), testing::HasSubstr("w.toml:1:1: \"flights\" is missing"));
  EXPECT_THAT(message("log = true", "logarithm = true"), testing::HasSubstr("unknown key \"logarithm\""));
}

}  // namespace tune_test
}  // namespace gustlab::test
