// Where the simulation and the recording differ, and whether anything is left after the chosen effects.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/gust_parts.hpp"
#include "diagnosis/selection.hpp"

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

// A reason to believe that something is left.
struct Alarm {
  std::string kind;     // omnibus | whiteness | floor | heteroscedastic
  std::string says;
  double size = 0.0;    // gain per degree of freedom, or ratio
};

struct Remainder {
  std::vector<Alarm> alarms;
  double omnibus_gain = 0.0;    // χ² of the family that still finds most
  double omnibus_share = 0.0;   // of all structure, what the omnibus test still finds
  bool gust_like = false;       // horizontal floor raised and slowly varying, or with a line, and no dependence on the state explains it
  GustParts gust;
};

// At the nominal vehicle, under the noise of the selected model. Linearises the session there.
std::vector<Mismatch> locate(Session& session, const Selection& selection);
// At the selected model; the session must be linearised there.
// `shadow`: a force of every flight's own was withdrawn, so what is left is no gust.
Remainder remainder(const Session& session, const Selection& selection, bool shadow);

// Per half second: the smoothed wrench (body axes, N and N m) and what it might depend on.
struct Blocks {
  std::vector<int> flight;
  std::vector<Eigen::Matrix<double, 6, 1>> wrench;
  std::vector<std::string> variable;
  std::vector<Eigen::VectorXd> value;       // per block, one number per variable
};
Blocks blocks(const Session& session, const std::vector<Smoothed>& smoothed);

}  // namespace gustlab::diagnosis
