// axial_inflow: a rotor that climbs pushes less, one that sinks pushes more; at the hubs, so roll and pitch are damped.
//
// f_i −= (at_hover / (N Ω_h)) Ω_i v_iz. Blade element theory: Leishman, Principles of Helicopter Aerodynamics, 2006, §3.2;
// for small multirotors: Bangura, Mahony, ACRA 2012; Svacha, Mohta, Kumar, ICUAS 2017. Plausible: a disc of ideal blades, whose flow a climb
// does not change, loses the weight over the induced speed (momentum theory, Leishman §2.2); twice that, as wakes and ducts are neither.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class AxialInflow final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("at_hover", at_hover_,
                   {.unit = "N s/m",
                    .help = "thrust of the whole vehicle lost per speed of climb, at hover speed",
                    .min = 0.0,
                    .natural = 0.05,
                    .scale = Scale::weight,
                    .plausible = 2.0,
                    .plausible_scale = Scale::weight_per_inflow});
  }

  void prepare(const VehicleModel& vehicle, double, const RandomStream&) override {
    per_speed_ = at_hover_ / (vehicle.rotor_count * vehicle.hover_speed_radps());
  }

  void on_rotor(Flow& flow, RotorSet& rotors) const override {
    if (per_speed_ == 0.0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i)
      rotors.thrust_N[i] -= per_speed_ * rotors.speed_radps[i] *
                            rotors.axis_B[i].dot(rotors.hub_velocity_B_mps(flow, static_cast<int>(i)));
  }

 private:
  double at_hover_ = 0.0;
  double per_speed_ = 0.0;  // N/((rad/s)(m/s)) per rotor
};

}  // namespace

std::unique_ptr<Effect> make_axial_inflow() { return std::make_unique<AxialInflow>(); }

}  // namespace gustlab
