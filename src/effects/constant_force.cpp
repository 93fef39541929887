// constant_force: a force that is fixed in the world, at the centre of mass: a tether, a hose, a magnet.
//
// F_W = (x, y, z). Newton.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class ConstantForce final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    constexpr double natural = 0.02, plausible = 0.33;  // of the weight
    visitor.number("x", force_W_N_.x(),
                   {.unit = "N",
                    .help = "force toward world x",
                    .natural = natural,
                    .scale = Scale::weight,
                    .plausible = plausible});
    visitor.number("y", force_W_N_.y(),
                   {.unit = "N",
                    .help = "force toward world y",
                    .natural = natural,
                    .scale = Scale::weight,
                    .plausible = plausible});
    visitor.number("z", force_W_N_.z(),
                   {.unit = "N",
                    .help = "force toward world z (up)",
                    .natural = natural,
                    .scale = Scale::weight,
                    .plausible = plausible});
  }

  void wrench(const Flow& flow, const RotorSet&, std::span<const double>, Wrench& total) const override {
    if (force_W_N_.isZero(0.0)) return;
    total.force_B_N += flow.R_WB.transpose() * force_W_N_;
  }

 private:
  Vector3 force_W_N_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Effect> make_constant_force() { return std::make_unique<ConstantForce>(); }

}  // namespace gustlab
