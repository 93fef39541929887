// my_effect: say here in one sentence what it does.
//
// Write the formula and where it is published. This one: a spring to a fixed point, F_W = −k (p − p₀).
#include "effects/effects.hpp"

namespace gustlab {

namespace {

// Five hooks, each doing nothing by default: on_body, on_actuation, on_rotor, wrench, on_measurement (include/gustlab/effect.hpp).
// At zero strength none may change a bit. The diagnosis fits the same object: natural is a typical size of a parameter, tolerance
// the size below which it is calibration and no missing physics.
class MyEffect final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number(
        "stiffness", stiffness_Npm_,
        {.unit = "N/m", .help = "of the spring", .min = 0.0, .max = 1e3, .natural = 0.01, .scale = Scale::weight});
    visitor.vector("anchor", anchor_W_m_, {.unit = "m", .help = "where it pulls to, world axes", .natural = 0.0});
  }

  void wrench(const Flow& flow, const RotorSet&, std::span<const double>, Wrench& total) const override {
    if (stiffness_Npm_ == 0.0) return;
    total.force_B_N += flow.R_WB.transpose() * (stiffness_Npm_ * (anchor_W_m_ - flow.position_W_m));
  }

 private:
  double stiffness_Npm_ = 0.0;
  Vector3 anchor_W_m_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Effect> make_my_effect() { return std::make_unique<MyEffect>(); }

}  // namespace gustlab
