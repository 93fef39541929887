// The makers of every effect; each lives in its own file of this folder.
#pragma once

#include <memory>

#include "gustlab/effect.hpp"

namespace gustlab {

std::unique_ptr<Effect> make_rotor_drag();
std::unique_ptr<Effect> make_mass();
std::unique_ptr<Effect> make_motor_lag();

}  // namespace gustlab
