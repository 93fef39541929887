// What a surface does to rotors near it, the ground below or a ceiling above.
#pragma once

#include <algorithm>

#include "gustlab/effect.hpp"

namespace gustlab {

// Thrust of each rotor times 1 + strength (R / 4 z)², z ≥ R the distance of its hub from the surface at `surface_z_m` in W.
// `side`: 1 above the surface, −1 below it.
inline void push_more_near(double surface_z_m, double side, double strength, const Flow& flow, RotorSet& rotors) {
  if (strength == 0.0) return;
  const double radius_m = flow.vehicle->rotor_radius_m;
  for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
    const Vector3 hub_B_m = flow.vehicle->center_of_mass_B_m + rotors.hub_B_m[i];
    const double height_m = flow.position_W_m.z() + flow.R_WB.row(2).dot(hub_B_m);
    const double ratio = radius_m / (4.0 * std::max(side * (height_m - surface_z_m), radius_m));
    rotors.thrust_N[i] *= 1.0 + strength * ratio * ratio;
  }
}

}  // namespace gustlab
