// Trims: what every vehicle is built with, each below its reporting tolerance. They are not missing physics, and many of them
// together must neither look like a name nor ring an alarm.
#pragma once

#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

// The largest of a group's values (SI, all columns) in its reporting tolerances; infinite where none is declared.
double size_in_tolerances(const Session& session, const Eigen::VectorXd& value, int group);

// Is a group at these values a trim? An estimate holds a share of what alike parts scatter, so a fifth more than the tolerance is.
bool below_tolerance(const Session& session, const Eigen::VectorXd& value, int group);

// Could trims of everything beside the chosen groups, small beforehand, look like this one of them? `total`: Gram matrix with
// coefficients counted from the nominal vehicle.
bool imitated_by_scatter(const Session& session, const Eigen::MatrixXd& total, const std::vector<int>& chosen,
                         int group);

// Every column with a reporting tolerance but those given, with this share of it as standard deviation.
std::vector<Trim> trims_beside(const Session& session, const std::vector<int>& columns, double share);

}  // namespace gustlab::diagnosis
