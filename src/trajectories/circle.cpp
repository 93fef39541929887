// circle: p = c + R (cos φ, sin φ, 0), φ = 2π t/T.
//
// The paper's circle starts one radius away from the vehicle: the Max of Table II is 1.100 ± 0.000 m, which is R.
#include "gustlab/errors.hpp"
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class Circle final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("radius_m", radius_m_, {.unit = "m", .help = "radius", .min = 0.0, .max = 1000.0});
    visitor.number("period_s", period_s_, {.unit = "s", .help = "time of one lap", .min = 0.1, .max = 1e4});
    visitor.vector("center_m", center_W_m_, {.unit = "m", .help = "centre, altitude included"});
    visitor.number("ramp_s", ramp_s_,
                   {.unit = "s", .help = "time to reach the full speed from rest", .min = 0.0, .max = 1e3});
    visitor.text("start", start_, {.help = "where the vehicle starts: center (as in the paper) or reference"});
    visitor.number("yaw_rad", yaw_rad_, {.unit = "rad", .help = "heading", .min = -pi, .max = pi});
  }

  void prepare() override {
    if (start_ != "center" && start_ != "reference")
      throw ParameterError("start",
                           "start = \"" + start_ + "\" is unknown (where the vehicle starts); use center or reference");
  }

  Reference at(double time_s) const override {
    const SineCosine turn = sine_cosine((2.0 * pi / period_s_) * ramped_time(time_s, ramp_s_));
    return reference_of(center_W_m_.x() + radius_m_ * turn.cosine, center_W_m_.y() + radius_m_ * turn.sine,
                        center_W_m_.z(), yaw_rad_);
  }

  Vector3 start_position_W_m() const override { return start_ == "center" ? center_W_m_ : at(0.0).position_W_m; }

  double lap_s() const override { return period_s_ + 0.5 * ramp_s_; }

 private:
  double radius_m_ = 1.1;
  double period_s_ = 24.0;
  Vector3 center_W_m_{0.0, 0.0, 1.0};
  double ramp_s_ = 0.0;
  std::string start_ = "center";
  double yaw_rad_ = 0.0;
};

}  // namespace

std::unique_ptr<Trajectory> make_circle() { return std::make_unique<Circle>(); }

}  // namespace gustlab
