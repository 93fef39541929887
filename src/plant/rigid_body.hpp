// One free rigid body in MuJoCo, airborne or near the ground.
#pragma once

#include <memory>
#include <vector>

#include "gustlab/vehicle.hpp"

namespace gustlab {

class RigidBody {
 public:
  RigidBody(const VehicleModel& vehicle, double step_s);
  ~RigidBody();

  void set(const VehicleState& state);
  void get(VehicleState& state) const;
  // Forgets contacts and warnings: what follows does not depend on what was.
  void forget();
  // What contacts remember, as numbers; load() returns where the next part of a snapshot begins.
  void save(std::vector<double>& out) const;
  const double* load(const double* in);
  // Wrench about the centre of mass; returns false when MuJoCo warned (state, velocity or acceleration not finite).
  bool step(const Wrench& wrench, const Matrix3& R_WB);
  int contacts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gustlab
