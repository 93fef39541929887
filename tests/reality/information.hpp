// what a set of flights can tell about a change of the vehicle: the Cramer-Rao bound by an innovation filter
#pragma once

#include <vector>

#include "flight.hpp"

namespace reality {

/// A change of the vehicle. `changed` holds one truth per flight; its effect is divided by `step`. If `push` is not
/// empty it holds, per flight and sample, an exogenous mean force [N, W] and torque [N m, B] instead.
struct Probe {
  std::vector<Truth> changed;
  double step = 1;
  std::vector<std::vector<Eigen::Matrix<double, 6, 1>>> push;
};

struct Information {
  Eigen::MatrixXd matrix;  // of the probes, sensor biases of each flight eliminated
  double samples = 0;      // scalar measurements, the degrees of freedom of DIAGNOSIS.md
};

/// Information of `flights` (flown by `base`, one truth per flight) about every probe, when turbulence is a free
/// Gauss-Markov wrench of known size and initial states are unknown.
Information information(const std::vector<const Flight*>& flights, const std::vector<Truth>& base,
                        const std::vector<Probe>& probes, const Columns& columns, const Noise& noise);

}  // namespace reality
