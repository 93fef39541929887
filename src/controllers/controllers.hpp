// The makers of every controller; each lives in its own file of this folder.
#pragma once

#include <memory>

#include "gustlab/controller.hpp"

namespace gustlab {

std::unique_ptr<Controller> make_pid();
std::unique_ptr<Controller> make_indi();
std::unique_ptr<Controller> make_asindy();
std::unique_ptr<Controller> make_daiml();
std::unique_ptr<Controller> make_geometric();
std::unique_ptr<Controller> make_l1();
std::unique_ptr<Controller> make_mpc();

}  // namespace gustlab
