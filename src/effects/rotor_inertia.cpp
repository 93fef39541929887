// rotor_inertia: a rotor that speeds up turns the vehicle the other way, and spinning rotors are gyroscopes.
//
// T −= Σ s_i I (Ω̇_i n_i + ω × Ω_i n_i). Angular momentum; Bouabdallah, Siegwart, ICRA 2005; Smeur, Chu, de Croon, JGCD
// 39(3) 2016, doi 10.2514/1.G001490 (the yaw part).
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class RotorInertia final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    // the rotors of a recorded Crazyflie have 1.9e-3 of its inertia in yaw (imrc, bare), thirteen times the tolerance
    visitor.number("inertia", inertia_kgm2_,
                   {.unit = "kg m^2",
                    .help = "of one rotor and its propeller about the axis",
                    .min = 0.0,
                    .natural = 1e-3,
                    .tolerance = 1.5e-4,
                    .scale = Scale::yaw_inertia});
  }

  void wrench(const Flow& flow, const RotorSet& rotors, std::span<const double>, Wrench& total) const override {
    if (inertia_kgm2_ == 0.0) return;
    Vector3 momentum_rate = Vector3::Zero(), momentum = Vector3::Zero();
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      const Vector3 spin = rotors.direction[i] * inertia_kgm2_ * rotors.axis_B[i];
      momentum_rate += rotors.acceleration_radps2[i] * spin;
      momentum += rotors.speed_radps[i] * spin;
    }
    total.torque_B_Nm -= momentum_rate + flow.body_rate_B_radps.cross(momentum);
  }

 private:
  double inertia_kgm2_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_rotor_inertia() { return std::make_unique<RotorInertia>(); }

}  // namespace gustlab
