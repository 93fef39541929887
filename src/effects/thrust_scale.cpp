// thrust_scale: every rotor pushes, and reacts, (1 + delta) times what its coefficient says.
//
// Air density, propeller wear, a thrust stand's scale: f = k_f Ω² is the momentum theory of Leishman 2006, §2.2.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class ThrustScale final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("delta", delta_,
                   {.unit = "-",
                    .help = "relative change of thrust and reaction torque of every rotor",
                    .min = -0.9,
                    .max = 10.0,
                    .natural = 0.05,
                    .tolerance = 0.012});
  }

  void on_rotor(Flow&, RotorSet& rotors) const override {
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      rotors.thrust_N[i] *= 1.0 + delta_;
      rotors.reaction_Nm[i] *= 1.0 + delta_;
    }
  }

 private:
  double delta_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_thrust_scale() { return std::make_unique<ThrustScale>(); }

}  // namespace gustlab
