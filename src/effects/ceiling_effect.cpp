// ceiling_effect: a rotor near the ceiling sucks itself up; each rotor by its own distance.
//
// f_i (1 + strength (R / 4 z_i)²), z_i ≥ R the distance of hub i below the ceiling. Same form as the ground's:
// Sanchez-Cuevas, Heredia, Ollero, ICUAS 2017 (bridge inspection).
#include "effects/effects.hpp"
#include "effects/near_surface.hpp"

namespace gustlab {

namespace {

class CeilingEffect final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("strength", strength_,
                   {.unit = "-",
                    .help = "how much more a rotor pushes, in units of (R / 4 distance)²",
                    .min = 0.0,
                    .natural = 5.0});
  }

  void on_rotor(Flow& flow, RotorSet& rotors) const override {
    if (const auto& surface = flow.vehicle->environment.ceiling_z_m)
      push_more_near(*surface, -1.0, strength_, flow, rotors);
  }

 private:
  double strength_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_ceiling_effect() { return std::make_unique<CeilingEffect>(); }

}  // namespace gustlab
