// lemniscate: a figure of eight that starts in its crossing.
//
// Gerono: (A sin φ, A sin φ cos φ). Bernoulli: the same over 1 + cos² φ. φ = 2π t/T.
#include "gustlab/errors.hpp"
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class Lemniscate final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("amplitude_m", amplitude_m_, {.unit = "m", .help = "half its length", .min = 0.0, .max = 1000.0});
    visitor.number("period_s", period_s_, {.unit = "s", .help = "time of one lap", .min = 0.1, .max = 1e4});
    visitor.vector("center_m", center_W_m_, {.unit = "m", .help = "crossing, altitude included"});
    visitor.number("ramp_s", ramp_s_,
                   {.unit = "s", .help = "time to reach the full speed from rest", .min = 0.0, .max = 1e3});
    visitor.text("shape", shape_, {.help = "gerono or bernoulli"});
    visitor.number("yaw_rad", yaw_rad_, {.unit = "rad", .help = "heading", .min = -pi, .max = pi});
  }

  void prepare() override {
    if (shape_ != "gerono" && shape_ != "bernoulli")
      throw ParameterError("shape",
                           "shape = \"" + shape_ + "\" is unknown (which figure of eight); use gerono or bernoulli");
    bernoulli_ = shape_ == "bernoulli";
  }

  Reference at(double time_s) const override {
    const auto [sine, cosine] = sine_cosine((2.0 * pi / period_s_) * ramped_time(time_s, ramp_s_));
    Jet x = amplitude_m_ * sine;
    if (bernoulli_) x = x / (1.0 + cosine * cosine);
    return reference_of(center_W_m_.x() + x, center_W_m_.y() + x * cosine, center_W_m_.z(), yaw_rad_);
  }

  double lap_s() const override { return period_s_ + 0.5 * ramp_s_; }

 private:
  double amplitude_m_ = 0.7;
  double period_s_ = 24.0;
  Vector3 center_W_m_{0.0, 0.0, 1.0};
  double ramp_s_ = 0.0;
  std::string shape_ = "gerono";
  double yaw_rad_ = 0.0;
  bool bernoulli_ = false;
};

}  // namespace

std::unique_ptr<Trajectory> make_lemniscate() { return std::make_unique<Lemniscate>(); }

}  // namespace gustlab
