// How rollouts are flown along a recording.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab::diagnosis {

struct ReplayOptions {
  std::vector<double> horizon_s{0.1, 0.5, 1.0};  // rising
  int stride = 0;                                // samples between window starts; 0: windows do not overlap
  int jobs = 1;
  double max_step_s = 1e-3;      // MuJoCo's Euler moves a body by ½ a dt² too much per step
  bool with_noise = true;        // also what measurement noise alone would give
  bool fit_per_flight = true;    // the model's values per flight, from what came before each window
  double command_delay_s = 0.0;  // by which the log's inputs come too early
  // What the caller knows better of the state that a window starts from: (row, state) → state. After sensor effects were
  // taken out; empty: as it is.
  std::function<void(std::size_t, VehicleState&)> correct_start;
};

}  // namespace gustlab::diagnosis
