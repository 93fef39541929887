// rotor_tilt: all rotors push along a tilted axis: a bent frame, a body frame that is not the frame of the motors.
//
// n_i = e3 + (x, y, 0) turns thrust and reaction torque. Exact alias of attitude_offset in translation.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class RotorTilt final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number(
        "x", x_rad_,
        {.unit = "rad", .help = "tilt of the axes toward forward", .min = -0.5, .max = 0.5, .natural = 0.01});
    visitor.number("y", y_rad_,
                   {.unit = "rad", .help = "tilt of the axes toward left", .min = -0.5, .max = 0.5, .natural = 0.01});
  }

  void on_rotor(Flow&, RotorSet& rotors) const override {
    if (x_rad_ == 0.0 && y_rad_ == 0.0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i)
      rotors.axis_B[i] += Vector3(x_rad_, y_rad_, 0.0);
  }

 private:
  double x_rad_ = 0.0, y_rad_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_rotor_tilt() { return std::make_unique<RotorTilt>(); }

}  // namespace gustlab
