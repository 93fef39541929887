// What a free body resists with when nothing accelerates it: its weight, and the torque of its turning. A Newton–Euler pass in spatial
// vectors (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5) about the centre of mass, for one body alone.
//
// MuJoCo's own pass looks for a tree of bodies and takes a quarter of a flight. This one sums in its order, so that the bits are the same;
// the centre of mass is rounded there as well, and so stands beside the body by what a double leaves over (tests/plant/state_test.cpp).
#pragma once

#include "util/three.hpp"

namespace gustlab {

struct FreeBody {
  double mass_kg;
  Vector3 inertia_kgm2;  // about its own axes
  double gravity_mps2;   // toward −z
};

// Force in world axes and torque in body axes. velocity: of the world; rate: of the body.
struct BiasForce {
  Vector3 force_W_N, torque_B_Nm;
};
BiasForce bias_force(const FreeBody& body, const Vector3& position_W_m, const Matrix3& R_WB,
                     const Vector3& velocity_W_mps, const Vector3& rate_B_radps);

}  // namespace gustlab
