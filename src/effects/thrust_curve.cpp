// thrust_curve: thrust does not follow Ω² exactly; right at hover, off above and below.
//
// f (1 + curvature (f / f_h − 1)), reaction torque alike; f_h the thrust of one rotor at hover. Maps that are
// quadratic only near hover: Bangura, Lim, Kim, Mahony, ICRA 2014. Tolerance: 1.2 % of the thrust (that of a thrust scale) at 1.5 of hover.
// Plausible: with −0.4 no input gives more than 1.2 of the weight.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class ThrustCurve final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("curvature", curvature_,
                   {.unit = "-",
                    .help = "relative change of thrust when the thrust doubles from hover",
                    .min = -0.9,
                    .max = 5.0,
                    .natural = 0.05,
                    .tolerance = 0.024,
                    .plausible = 0.4});
  }

  void on_rotor(Flow& flow, RotorSet& rotors) const override {
    const double hover_thrust_N = flow.vehicle->hover_thrust_N();
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      const double factor = 1.0 + curvature_ * (rotors.thrust_N[i] / hover_thrust_N - 1.0);
      rotors.thrust_N[i] *= factor;
      rotors.reaction_Nm[i] *= factor;
    }
  }

 private:
  double curvature_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_thrust_curve() { return std::make_unique<ThrustCurve>(); }

}  // namespace gustlab
