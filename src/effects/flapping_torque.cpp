// flapping_torque: the advancing blade lifts more, so a moving rotor pitches the vehicle nose up (negative: nose down).
//
// T += Σ coefficient Ω_i (v_i × n_i). Blade flapping and hub moments: Hoffmann, Huang, Waslander, Tomlin, AIAA GNC 2007;
// Mahony, Kumar, Corke, RAM 19(3) 2012, doi 10.1109/MRA.2012.2206474.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class FlappingTorque final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("coefficient", coefficient_Ns2_,
                   {.unit = "N s^2",
                    .help = "torque of one rotor per its speed and the speed in its plane; > 0: nose up",
                    .min = 0.0,
                    .natural = 3e-6,
                    .scale = Scale::arm});
  }

  void wrench(const Flow& flow, const RotorSet& rotors, std::span<const double>, Wrench& total) const override {
    if (coefficient_Ns2_ == 0.0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i)
      total.torque_B_Nm += coefficient_Ns2_ * rotors.speed_radps[i] *
                           rotors.hub_velocity_B_mps(flow, static_cast<int>(i)).cross(rotors.axis_B[i]);
  }

 private:
  double coefficient_Ns2_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_flapping_torque() { return std::make_unique<FlappingTorque>(); }

}  // namespace gustlab
