// rotor_drag: each rotor drags against its in-plane motion, in proportion to its speed.
//
// F_i = −(at_hover / (N Ω_h)) Ω_i v_ip at hub i, torque r_i × F_i. Faessler, Franchi, Scaramuzza, RA-L 3(2) 2018,
// doi 10.1109/LRA.2017.2776353; blade flapping and induced drag: Mahony, Kumar, Corke, RAM 19(3) 2012.
#include "effects/effects.hpp"
#include "util/three.hpp"

namespace gustlab {

namespace {

class RotorDrag final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("at_hover", at_hover_,
                   {.unit = "N s/m",
                    .help = "lateral drag of the whole vehicle at hover speed",
                    .min = 0.0,
                    .natural = 0.016,
                    .scale = Scale::weight});
  }

  void prepare(const VehicleModel& vehicle, double, const RandomStream&) override {
    per_speed_ = at_hover_ / (vehicle.rotor_count * vehicle.hover_speed_radps());
  }

  void wrench(const Flow& flow, const RotorSet& rotors, std::span<const double>, Wrench& total) const override {
    if (per_speed_ == 0.0) return;
    Three force_sum = total.force_B_N, torque_sum = total.torque_B_Nm;
    const Three air = flow.air_velocity_B_mps, rate = flow.body_rate_B_radps;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      const Three hub = rotors.hub_B_m[i], axis = rotors.axis_B[i];
      const Three velocity = air + cross(rate, hub);
      const Three in_plane = velocity - dot(axis, velocity) * axis;
      const Three force = -per_speed_ * rotors.speed_radps[i] * in_plane;
      force_sum = force_sum + force;
      torque_sum = torque_sum + cross(hub, force);
    }
    total.force_B_N = force_sum;
    total.torque_B_Nm = torque_sum;
  }

 private:
  double at_hover_ = 0.0;
  double per_speed_ = 0.0;  // N/((rad/s)(m/s)) per rotor
};

}  // namespace

std::unique_ptr<Effect> make_rotor_drag() { return std::make_unique<RotorDrag>(); }

}  // namespace gustlab
