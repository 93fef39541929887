// Experiments for tests: short flights of the Crazyflie in a gust.
#pragma once

#include <string>

#include "simulation/experiment.hpp"
#include "support/temporary_folder.hpp"

namespace gustlab::test {

inline const std::string small_experiment = R"(
format = "gustlab-experiment/1"
name = "small"
vehicle = "crazyflie"
trajectories = ["circle", "hover"]
controllers = ["pid"]
replicates = 3
duration_s = 1.0
[environment]
ground_z_m = 0.0
[trajectory.circle]
period_s = 5.0
start = "reference"
[[effect]]
type = "gust"
sigma_xy = 0.03
correlation_time = 0.5
)";

inline Experiment read_text_experiment(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const TemporaryFolder folder;
  return read_experiment(folder.write("experiment.toml", text), overrides);
}

}  // namespace gustlab::test
