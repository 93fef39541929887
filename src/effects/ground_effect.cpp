// ground_effect: a rotor near the ground pushes more; each rotor by its own height, so a tilted vehicle is righted.
//
// f_i (1 + strength (R / 4 z_i)²), z_i ≥ R the height of hub i. Cheeseman, Bennett, ARC R&M 3021, 1955 (strength 1, to first
// order); multirotors show 4–10: Sanchez-Cuevas, Heredia, Ollero, IJAE 2017, doi 10.1155/2017/1823056.
#include <algorithm>

#include "effects/effects.hpp"

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
    const auto& surface = flow.vehicle->environment.ground_z_m;
    if (strength_ == 0.0 || !surface) return;
    const double radius_m = flow.vehicle->rotor_radius_m;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      const Vector3 hub_B_m = flow.vehicle->center_of_mass_B_m + rotors.hub_B_m[i];
      const double height_m = flow.position_W_m.z() + flow.R_WB.row(2).dot(hub_B_m);
      const double ratio = radius_m / (4.0 * std::max(height_m - *surface, radius_m));
      rotors.thrust_N[i] *= 1.0 + strength_ * ratio * ratio;
    }
  }

 private:
  double strength_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_ground_effect() { return std::make_unique<GroundEffect>(); }

}  // namespace gustlab
