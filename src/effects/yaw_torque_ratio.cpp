// yaw_torque_ratio: the reaction torque per thrust differs from the vehicle file's, for all rotors alike.
//
// c_τ (1 + delta); below −1 the torque changes sign. Blade profile and induced power: Leishman 2006, §2.3.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class YawTorqueRatio final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("delta", delta_,
                   {.unit = "-",
                    .help = "relative change of the reaction torque alone",
                    .min = -100.0,
                    .max = 100.0,
                    .natural = 0.05,
                    .tolerance = 0.05,
                    .plausible = 0.8});
  }

  void on_rotor(Flow&, RotorSet& rotors) const override {
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) rotors.reaction_Nm[i] *= 1.0 + delta_;
  }

 private:
  double delta_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_yaw_torque_ratio() { return std::make_unique<YawTorqueRatio>(); }

}  // namespace gustlab
