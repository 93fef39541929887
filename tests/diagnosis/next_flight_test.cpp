// What to fly next, and whether it then does what was promised.
#include <gmock/gmock.h>

#include "diagnosis/diagnose.hpp"
#include "simulation/concealed_trials.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::diagnosis {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// hovers and slow circles at one heading, and if wanted a flight of many sines with yaw; an attitude offset is concealed
std::string trials(const std::string& fit, bool large) {
  return R"(
format = "gustlab-trials/1"
name = "hover"
vehicle = ")" + std::string(large ? "iris" : "crazyflie") + R"("
trajectories = ["hover", "circle", "spiral", "multisine"]
controllers = ["geometric"]
fit = [)" + fit + R"(]
holdout = ["spiral"]
sensors = ["pose", "gyroscope"]
duration_s = 12.0
step_s = )" + (large ? "0.0025" : "0.002") + R"(
[trajectory.circle]
period_s = 20.0
ramp_s = 2
start = "reference"
[trajectory.spiral]
ramp_s = 2
[trajectory.multisine]
center_m = [0, 0, 1.2]
yaw_amplitude_rad = 1.2
yaw_frequency_hz = 0.25
[[effect]]
type = "measurement_noise"
position_sd = 0.0005
attitude_sd = 0.002
rate_sd = 0.01
[[effect]]
type = "gust"
)" + (large ? "sigma_xy = 0.1\nsigma_z = 0.1" : "sigma_xy = 0.003\nsigma_z = 0.003") + R"(
correlation_time = 0.15
[[trial]]
name = "offset"
effects = [{type = "attitude_offset", x = 0.02}]
)";
}

Diagnosis diagnose_trial(const TemporaryFolder& folder, const std::string& name, const std::string& fit, std::size_t flights, bool large = false) {
  const TrialsFile file = read_trials_file(folder.write(name + ".toml", trials(fit, large)));
  fly_concealed_trials(file, folder.file(name), 2);
  DiagnoseOptions options;
  for (std::size_t i = 1; i <= flights; ++i) options.fit.push_back(folder.file(name) + "/offset/fit_" + std::to_string(i) + ".csv");
  options.holdout = {folder.file(name) + "/offset/holdout_1.csv"};
  options.jobs = 2;
  return diagnose(options);
}

TEST(NextFlight, NamesAFlightThatThenSeparatesWhatCouldNotBeTold) {
  const TemporaryFolder folder;
  const Diagnosis before = diagnose_trial(folder, "before", "\"hover\", \"circle\"", 2);
  ASSERT_EQ(before.effects.size(), 1u);
  // at one heading a tilted sensor and a constant push look alike
  ASSERT_THAT(before.effects[0].classmates, Contains("attitude_offset"));
  ASSERT_THAT(before.effects[0].classmates, Contains("constant_force"));
  EXPECT_EQ(before.next_trajectory, "multisine") << before.next_why;
  EXPECT_THAT(before.next_why, HasSubstr("would separate"));
  EXPECT_EQ(to_json(before)["next_flight"]["parameters"]["yaw_amplitude_rad"], 1.2);

  const Diagnosis after = diagnose_trial(folder, "after", "\"hover\", \"circle\", \"multisine\"", 3);
  ASSERT_EQ(after.effects.size(), 1u);
  EXPECT_EQ(after.effects[0].classmates, std::vector<std::string>{"attitude_offset"});
}

TEST(NextFlight, IsSizedByTheVehicle) {
  const TemporaryFolder folder;
  const Diagnosis d = diagnose_trial(folder, "iris", "\"hover\"", 1, true);
  EXPECT_FALSE(d.next_trajectory.empty());
  // five times the arm, five times the path
  const auto next = to_json(d)["next_flight"]["parameters"];
  EXPECT_GT(next.contains("amplitude_m") ? next["amplitude_m"][0].get<double>() : next["radius_m"].get<double>(), 1.5);
}

}  // namespace
}  // namespace gustlab::diagnosis
