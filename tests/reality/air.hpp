// rotors and fuselage in moving air, near ground, ceiling and walls
#pragma once

#include "body.hpp"

namespace reality {

/// Thrusts, drags, flapping and reaction torques of all rotors, summed in B about the centre of mass.
Wrench rotors_in_air(const Truth& truth, const Motion& m, const Drive& drive);

/// Drag of the fuselage, suction of a wall, and the forces outside the catalogue [N, W], at the centre of mass.
Vec3 fuselage_force_W(const Truth& truth, const Motion& m, double thrust_N);

}  // namespace reality
