// spiral: Archimedes' spiral from the centre outwards, p = c + R τ (cos 2πnτ, sin 2πnτ, 0) + (0, 0, hτ), τ = t/T.
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class Spiral final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("radius_m", radius_m_, {.unit = "m", .help = "radius at its end", .min = 0.0, .max = 1000.0});
    visitor.number("turns", turns_, {.help = "turns until its end", .min = 0.0, .max = 1000.0});
    visitor.number("length_s", length_s_, {.unit = "s", .help = "time until its end", .min = 0.1, .max = 1e4});
    visitor.number("climb_m", climb_m_, {.unit = "m", .help = "height gained until its end", .min = -1e3, .max = 1e3});
    visitor.vector("center_m", center_W_m_, {.unit = "m", .help = "where it begins"});
    visitor.number("ramp_s", ramp_s_,
                   {.unit = "s", .help = "time to reach the full pace from rest", .min = 0.0, .max = 1e3});
    visitor.number("yaw_rad", yaw_rad_, {.unit = "rad", .help = "heading", .min = -pi, .max = pi});
  }

  Reference at(double time_s) const override {
    const Jet progress = (1.0 / length_s_) * ramped_time(time_s, ramp_s_);
    const SineCosine turn = sine_cosine(2.0 * pi * turns_ * progress);
    const Jet radius = radius_m_ * progress;
    return reference_of(center_W_m_.x() + radius * turn.cosine, center_W_m_.y() + radius * turn.sine,
                        center_W_m_.z() + climb_m_ * progress, yaw_rad_);
  }

  double duration_s() const override { return length_s_ + 0.5 * ramp_s_; }

 private:
  double radius_m_ = 0.6;
  double turns_ = 2.0;
  double length_s_ = 24.0;
  double climb_m_ = 0.0;
  Vector3 center_W_m_{0.0, 0.0, 1.0};
  double ramp_s_ = 0.0;
  double yaw_rad_ = 0.0;
};

}  // namespace

std::unique_ptr<Trajectory> make_spiral() { return std::make_unique<Spiral>(); }

}  // namespace gustlab
