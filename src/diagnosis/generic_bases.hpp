// Columns without a physical name: they ask whether anything is left, not what it is.
#pragma once

#include <string>
#include <vector>

#include "diagnosis/session.hpp"
#include "diagnosis/trims.hpp"

namespace gustlab::diagnosis {

// A family of columns per flight: m pushes per sample, to be appended to the filter's own.
struct BasisFamily {
  std::string name;
  std::vector<std::vector<Pushes>> columns;   // [flight][sample]
  int size = 0;
};
// force of position, force and torque of body velocity, of time, and torque of past commands
std::vector<BasisFamily> omnibus_bases(const Session& session);
// a dozen smooth functions of the state acting on one channel each: force x y z, torque x y z in the body
std::vector<BasisFamily> channel_bases(const Session& session);

// Gram matrix of [these columns of the catalogue, the family, z], whitened under the session's noise, over all flights.
Eigen::MatrixXd gram_with(const Session& session, const BasisFamily& family, const std::vector<int>& columns);
// What a family gains beyond the given columns (always free with them) and small values of the trims.
double gain_of(const Session& session, const BasisFamily& family, std::vector<int> columns, const std::vector<Trim>& trims = {});

}  // namespace gustlab::diagnosis
