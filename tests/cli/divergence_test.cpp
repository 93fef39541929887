// After a NaN MuJoCo resets the state and flies on, writes MUJOCO_LOG.TXT where it stands, and its error handler waits for
// a key: none of it reaches a user.
#include <gmock/gmock.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "support/program.hpp"

namespace gustlab {
namespace divergence_test {

const char* const experiment_text = R"(format = "gustlab-experiment/1"
name = "torn"
vehicle = "crazyflie"
trajectories = ["hover"]
controllers = ["pid"]
replicates = 2
duration_s = 1.0
max_error_m = 1e5
[[effect]]
type = "constant_force"
)";

// standard input from which nothing ever comes, for as long as it lives
class SilentInput {
 public:
  SilentInput() {
    if (pipe(ends_) != 0 || (before_ = dup(STDIN_FILENO)) < 0 || dup2(ends_[0], STDIN_FILENO) < 0)
      throw std::runtime_error("no pipe");
  }
  ~SilentInput() {
    dup2(before_, STDIN_FILENO);
    for (const int end : {ends_[0], ends_[1], before_}) close(end);
  }
  SilentInput(const SilentInput&) = delete;

 private:
  int ends_[2] = {-1, -1}, before_ = -1;
};

class Divergence : public ::testing::TestWithParam<const char*> {};

TEST_P(Divergence, IsAResultAndLeavesNothingElse) {
  const TemporaryFolder folder;
  folder.write("torn.toml", std::string(experiment_text) + "x = " + GetParam() + "\n");
  const SilentInput input;
  const auto gustlab = [&](std::vector<std::string> arguments) {
    // 124: it waited
    arguments.insert(arguments.begin(), {"timeout", "30", test::gustlab_program()});
    return test::run_program(arguments, folder.path().string());
  };
  const test::Said run = gustlab({"run", "torn.toml", "--trajectory", "hover", "--controller", "pid", "--out", "one"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto outcome = nlohmann::json::parse(read_text(folder.file("one/outcome.json")));
  EXPECT_EQ(outcome["outcome"], "diverged");
  EXPECT_LT(outcome["duration_s"], 0.1);
  const test::Said sweep = gustlab({"sweep", "torn.toml", "--out", "all", "--jobs", "2"});
  ASSERT_EQ(sweep.exit_code, 0) << sweep.err;
  const test::Said table = gustlab({"table", "all", "--format", "md"});
  EXPECT_THAT(table.out, ::testing::HasSubstr("| 0/2 |"));
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    left.push_back(entry.path().filename().string());
  EXPECT_THAT(left, ::testing::UnorderedElementsAre("torn.toml", "one", "all"));
}

// beyond what MuJoCo takes for a number, and beyond what is one
INSTANTIATE_TEST_SUITE_P(ForceInNewton, Divergence, ::testing::Values("1e10", "1e300"));

}  // namespace divergence_test
}  // namespace gustlab
