// Trims: what every vehicle is built with, each below its reporting tolerance. They are not missing physics, and many of them
// together must neither look like a name nor ring an alarm.
#pragma once

#include "diagnosis/selection.hpp"

namespace gustlab::diagnosis {

// Is a group at these values (SI, all columns) a trim?
bool below_tolerance(const Session& session, const Eigen::VectorXd& value, int group);

// Could trims of everything beside the chosen groups, small beforehand, look like this one of them? `total`: Gram matrix with
// coefficients counted from the nominal vehicle.
bool imitated_by_scatter(const Session& session, const Eigen::MatrixXd& total, const std::vector<int>& chosen, int group,
                         const SelectionOptions& options);

// Every column with a reporting tolerance but those given, with this share of it as standard deviation.
std::vector<Trim> trims_beside(const Session& session, const std::vector<int>& columns, double share);

}  // namespace gustlab::diagnosis
