// The makers of every trajectory; each lives in its own file of this folder.
#pragma once

#include <memory>

#include "gustlab/trajectory.hpp"

namespace gustlab {

std::unique_ptr<Trajectory> make_hover();
std::unique_ptr<Trajectory> make_circle();
std::unique_ptr<Trajectory> make_lemniscate();
std::unique_ptr<Trajectory> make_spiral();
std::unique_ptr<Trajectory> make_waypoints();
std::unique_ptr<Trajectory> make_multisine();
std::unique_ptr<Trajectory> make_recorded();

}  // namespace gustlab
