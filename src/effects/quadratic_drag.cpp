// quadratic_drag: the body drags against the square of its velocity through the air, at the centre of mass.
//
// F_B −= ½ ρ area |v_r| v_r, with one area (drag coefficient included) for x and y and one for z.
// Hoerner, Fluid-Dynamic Drag, 1965, ch. 3 (bluff bodies).
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class QuadraticDrag final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("area_xy", area_xy_m2_,
                   {.unit = "m^2",
                    .help = "drag area (area × coefficient) in x and y",
                    .min = 0.0,
                    .natural = 0.3,
                    .scale = Scale::arm});
    visitor.number("area_z", area_z_m2_,
                   {.unit = "m^2",
                    .help = "drag area (area × coefficient) in z",
                    .min = 0.0,
                    .natural = 0.3,
                    .scale = Scale::arm});
  }

  void wrench(const Flow& flow, const RotorSet&, std::span<const double>, Wrench& total) const override {
    if (area_xy_m2_ == 0.0 && area_z_m2_ == 0.0) return;
    const Vector3& velocity = flow.air_velocity_B_mps;
    const double momentum = 0.5 * air_density_kgpm3 * velocity.norm();
    total.force_B_N -= momentum * Vector3(area_xy_m2_, area_xy_m2_, area_z_m2_).cwiseProduct(velocity);
  }

 private:
  double area_xy_m2_ = 0.0, area_z_m2_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_quadratic_drag() { return std::make_unique<QuadraticDrag>(); }

}  // namespace gustlab
