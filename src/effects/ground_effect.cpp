// ground_effect: a rotor near the ground pushes more; each rotor by its own height, so a tilted vehicle is righted.
//
// f_i (1 + strength (R / 4 z_i)²), z_i ≥ R the height of hub i. Cheeseman, Bennett, ARC R&M 3021, 1955 (strength 1, to first
// order); multirotors show 4–10: Sanchez-Cuevas, Heredia, Ollero, IJAE 2017, doi 10.1155/2017/1823056.
#include "effects/effects.hpp"
#include "effects/near_surface.hpp"

namespace gustlab {

namespace {

class GroundEffect final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("strength", strength_,
                   {.unit = "-",
                    .help = "how much more a rotor pushes, in units of (R / 4 distance)²",
                    .min = 0.0,
                    .natural = 5.0});
  }

  void on_rotor(Flow& flow, RotorSet& rotors) const override {
    if (const auto& surface = flow.vehicle->environment.ground_z_m)
      push_more_near(*surface, 1.0, strength_, flow, rotors);
  }

 private:
  double strength_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_ground_effect() { return std::make_unique<GroundEffect>(); }

}  // namespace gustlab
