// translational_lift: a rotor that moves through the air in its plane meets cleaner inflow and pushes more.
//
// f_i += coefficient |v_ip|². Glauert's induced velocity in forward flight, expanded to second order: Leishman, Principles
// of Helicopter Aerodynamics, 2006, §2.14; as a fitted term: Faessler et al., RA-L 3(2) 2018, their k_h.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class TranslationalLift final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("coefficient", coefficient_kgpm_,
                   {.unit = "kg/m",
                    .help = "thrust that one rotor gains per squared speed in its plane",
                    .min = 0.0,
                    .natural = 0.007,
                    .scale = Scale::arm});
  }

  void on_rotor(Flow& flow, RotorSet& rotors) const override {
    if (coefficient_kgpm_ == 0.0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      const Vector3 velocity = rotors.hub_velocity_B_mps(flow, static_cast<int>(i));
      const double axial = rotors.axis_B[i].dot(velocity);
      rotors.thrust_N[i] += coefficient_kgpm_ * (velocity.squaredNorm() - axial * axial);
    }
  }

 private:
  double coefficient_kgpm_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_translational_lift() { return std::make_unique<TranslationalLift>(); }

}  // namespace gustlab
