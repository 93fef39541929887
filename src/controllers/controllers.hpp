// The makers of every controller; each lives in its own file of this folder.
#pragma once

#include <memory>

#include "gustlab/controller.hpp"

namespace gustlab {

std::unique_ptr<Controller> make_pid();

}  // namespace gustlab
