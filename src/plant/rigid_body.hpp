// One free rigid body in MuJoCo, airborne or near the ground.
#pragma once

#include <memory>
#include <vector>

#include "gustlab/effect.hpp"

namespace gustlab {

// MuJoCo's body stands at the centre of mass, whose motion is then free of the turning: a moved centre of mass costs nothing
// in MuJoCo, and a step conserves momentum. States are of the body's origin, as everywhere else.
class RigidBody {
 public:
  RigidBody(const VehicleModel& vehicle, double step_s);
  ~RigidBody();

  // Forgets contacts and warnings: what follows does not depend on what was.
  void forget();
  // What contacts remember, as numbers; load() returns where the next part of a snapshot begins.
  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Advances pose, velocity and body rate over one step; `flow` is at the state, the wrench about the centre of mass.
  // Returns false when MuJoCo warned (state, velocity or acceleration not finite).
  bool step(const Flow& flow, const Wrench& wrench, VehicleState& state);
  int contacts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gustlab
