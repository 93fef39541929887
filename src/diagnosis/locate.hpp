// Where the simulation and the recording differ.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/remainder.hpp"

namespace gustlab::diagnosis {

// Where in the state space a mismatch sits.
struct Region {
  std::string variable;
  double above = 0.0;   // |variable| above which most of it is found
  double share = 0.0;   // of its energy
};

struct Mismatch {
  std::string channel;  // force_x|y|z, torque_x|y|z, actuation, timing
  bool significant = false;
  double p_value = 1.0;
  double rms = 0.0, noise_rms = 0.0;
  std::string unit;
  std::vector<Region> where;
};

// At the nominal vehicle, under the noise of the selected model, and where alarms are. Linearises the session there.
std::vector<Mismatch> locate(Session& session, const Selection& selection, const Remainder& rest);
// Per half second: the smoothed wrench (body axes, N and N m) and what it might depend on.
struct Blocks {
  std::vector<int> flight;
  std::vector<Eigen::Matrix<double, 6, 1>> wrench;
  std::vector<std::string> variable;
  std::vector<Eigen::VectorXd> value;       // per block, one number per variable
};
Blocks blocks(const Session& session, const std::vector<Smoothed>& smoothed);

}  // namespace gustlab::diagnosis
