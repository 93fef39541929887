// gustlab train: the experiment that is shipped gives the weights that are shipped.
#include <gmock/gmock.h>

#include <filesystem>

#include "control/network.hpp"
#include "simulation/experiment.hpp"
#include "simulation/flight.hpp"
#include "support/program.hpp"
#include "util/sha256.hpp"

namespace gustlab::test {
namespace train_command_test {

namespace fs = std::filesystem;

std::string shipped(const std::string& name) { return (fs::path(source_directory()) / name).string(); }

TEST(TrainCommand, WritesTheSameBytesForAnyJobs) {
  const TemporaryFolder folder;
  for (const char* jobs : {"1", "3"}) {
    const Said said = gustlab({"train", "collect_iris", "--out", folder.file(jobs), "--epochs", "2", "--jobs", jobs,
                               "--set", "replicates=1", "--set", "duration_s=20"});
    ASSERT_EQ(said.exit_code, 0) << said.err;
    EXPECT_THAT(said.out, testing::HasSubstr("held out new_direction: "));
  }
  EXPECT_EQ(read_text(folder.file("1")), read_text(folder.file("3")));
  EXPECT_EQ(parse_network(read_text(folder.file("1")), "w").layers.size(), 4u);
}

TEST(TrainCommand, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const Said one = gustlab({"train", "ci_small", "--out", folder.file("w")});
  EXPECT_EQ(one.exit_code, 2);
  EXPECT_THAT(one.err, testing::HasSubstr(
                           "to train on (the discriminator tells them apart); give at least two [[variant]] tables"));
  const Said crash = gustlab({"train", "collect_iris", "--out", folder.file("w"), "--set", "effect.gust.strength=40"});
  EXPECT_EQ(crash.exit_code, 2);
  EXPECT_THAT(crash.err, testing::HasSubstr("(training needs whole flights); use less wind"));
  for (const char* adversary : {"nan", "inf", "-1", "1001"}) {
    const Said said = gustlab({"train", "collect_iris", "--out", folder.file("w"), "--adversary", adversary});
    EXPECT_EQ(said.exit_code, 2);
    EXPECT_EQ(said.err, "gustlab: --adversary: " + std::string(adversary) +
                            " is not a number from 0 to 1000 (see gustlab train --help)\n");
  }
  EXPECT_FALSE(fs::exists(folder.file("w")));
}

// the whole training takes half a minute; that the experiment is still the one that the weights name takes none of it
TEST(ShippedWeights, AreOfTheShippedExperiment) {
  const NetworkWeights weights = parse_network(read_text(shipped("configs/daiml.weights")), "configs/daiml.weights");
  std::string resolved, named;
  for (const Experiment& variant : read_variants(shipped("experiments/collect_iris.toml")))
    resolved += resolved_text(variant);
  for (const auto& [key, value] : weights.provenance)
    if (key == "experiment sha256") named = value;
  EXPECT_EQ(named, sha256(resolved)) << "train again: gustlab train collect_iris --out configs/daiml.weights";
}

// GIVEN gusts of seeds that no training saw WHEN daiml flies with its network THEN it beats itself without, of the same gains, and PID
TEST(ShippedWeights, BeatTheConstantAndPidInGustsOnBothVehicles) {
  for (const char* name : {"table1_iris", "table2_crazyflie"}) {
    const Experiment experiment =
        read_experiment(shipped("experiments/" + std::string(name) + ".toml"),
                        {"trajectories=[\"lemniscate\"]", "controllers=[\"pid\",\"constant\",\"daiml\"]",
                         "controller.constant={type=\"daiml\",weights=\"\"}", "controller.daiml.bandwidth_radps=0",
                         "controller.daiml.tilt_limit_deg=30", "controller.daiml.feedforward=true", "replicates=4",
                         "first_replicate=51", "duration_s=24"});
    std::array<double, 3> rmse_m{};
    for (const RunSpec& spec : plan(experiment)) {
      const RunRecord record = run(experiment, spec);
      EXPECT_EQ(record.outcome, Outcome::completed);
      rmse_m[spec.controller] += record.error.planar.rmse_m / 4.0;
    }
    EXPECT_LT(rmse_m[2], 0.95 * rmse_m[1]) << name;
    EXPECT_LT(rmse_m[2], 0.8 * rmse_m[0]) << name;
  }
}

}  // namespace train_command_test
}  // namespace gustlab::test
