// MuJoCo's own step without anything of ours: what the closed loop is measured against.
#pragma once

#include <memory>

namespace gustlab {

class BareStep {
 public:
  // stock: a quadrotor as modelling guides draw it, with floor, geometry, site actuators and an IMU, hovering in the air.
  // minimal: a free body with contact and constraints off.
  enum class Model { stock, minimal };
  explicit BareStep(Model model, double step_s = 0.002);
  ~BareStep();
  void step(int count);

 private:
  struct World;
  std::unique_ptr<World> world_;
};

}  // namespace gustlab
