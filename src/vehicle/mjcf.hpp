// What a vehicle's MJCF says of its rigid body. Declared here, implemented in plant/, the only code that knows MuJoCo.
#pragma once

#include <string>
#include <vector>

#include "gustlab/vehicle.hpp"

namespace gustlab {

// The body with the free joint, with everything welded to it, in its own axes from its origin.
struct MjcfBody {
  double mass_kg = 0.0;
  Vector3 center_of_mass_B_m = Vector3::Zero();
  Matrix3 inertia_B_kgm2 = Matrix3::Zero();  // about the centre of mass
  double gravity_mps2 = 0.0;
  struct Site {
    std::string name;
    Vector3 position_B_m;
    Vector3 axis_B;  // the site's z axis
  };
  std::vector<Site> sites;
  std::vector<CollisionShape> shapes;
  std::string bytes;  // the file, and those that it names, as read
};

// Throws ConfigError with file:line:col as far as MuJoCo tells it: not MJCF, not exactly one free joint and no other,
// gravity that is not along −z, a mesh that collides, an included file, an asset outside the file's folder.
MjcfBody read_mjcf(const std::string& path);

}  // namespace gustlab
