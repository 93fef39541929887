// Whether what is left depends on where the vehicle is or how fast: more than the same series do when they are moved along
// their flights, so that slow series are not taken for slow functions of the state.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

// y with each flight's part moved on in a circle by `shift` rows.
Eigen::VectorXd moved_along(const Eigen::VectorXd& y, const std::vector<int>& flight, Eigen::Index shift);

// Of the horizontal disturbance (half-second means, m/s²) on functions of position, and of velocity.
bool depends_on_state(const Session& session, const std::vector<Smoothed>& smoothed);

}  // namespace gustlab::diagnosis
