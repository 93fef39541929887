// mass: the vehicle weighs m (1 + delta); its inertia stays, and so do its rotors.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class Mass final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("delta", delta_,
                   {.unit = "-",
                    .help = "relative change of the mass",
                    .min = -0.9,
                    .max = 10.0,
                    .natural = 0.05,
                    .tolerance = 0.012,
                    .plausible = 0.6});  // a scale knows better; more is a thrust map that is wrong
  }

  void on_body(VehicleModel& vehicle) const override {
    if (vehicle.rated_mass_kg == 0.0) vehicle.rated_mass_kg = vehicle.mass_kg;
    vehicle.mass_kg *= 1.0 + delta_;
  }

 private:
  double delta_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_mass() { return std::make_unique<Mass>(); }

}  // namespace gustlab
