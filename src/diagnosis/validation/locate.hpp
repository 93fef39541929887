// Where the simulation and the recording differ.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/result/findings.hpp"
#include "diagnosis/validation/remainder.hpp"

namespace gustlab::diagnosis {

// At the nominal vehicle, under the noise of the selected model, and where alarms are. Linearises the session there.
std::vector<Mismatch> locate(Session& session, const Selection& selection, const Remainder& rest);
// Per half second: the smoothed wrench (body axes, N and N m) and what it might depend on.
struct Blocks {
  std::vector<int> flight;
  std::vector<Eigen::Matrix<double, 6, 1>> wrench;
  std::vector<std::string> variable;
  std::vector<Eigen::VectorXd> value;  // per block, one number per variable
};
Blocks blocks(const Session& session, const std::vector<Smoothed>& smoothed);

}  // namespace gustlab::diagnosis
