// my_trajectory: say here in one sentence what it is.
//
// Write the formula. This one: to and fro on a line, p = c + A (sin φ, 0, 0), φ = 2π t/T. Formulas of a Jet come out with all
// derivatives to snap, exactly (trajectories/jet.hpp).
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class MyTrajectory final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("amplitude_m", amplitude_m_, {.unit = "m", .help = "half of the way", .min = 0.0, .max = 1000.0});
    visitor.number("period_s", period_s_, {.unit = "s", .help = "to and fro once", .min = 0.1, .max = 1e4});
    visitor.vector("center_m", center_W_m_, {.unit = "m", .help = "middle of the way, altitude included"});
    visitor.number("ramp_s", ramp_s_,
                   {.unit = "s", .help = "time to reach the full speed from rest", .min = 0.0, .max = 1e3});
  }

  Reference at(double time_s) const override {
    const SineCosine turn = sine_cosine((2.0 * pi / period_s_) * ramped_time(time_s, ramp_s_));
    return reference_of(center_W_m_.x() + amplitude_m_ * turn.sine, center_W_m_.y(), center_W_m_.z(), 0.0);
  }

 private:
  double amplitude_m_ = 1.0;
  double period_s_ = 6.0;
  Vector3 center_W_m_{0.0, 0.0, 1.0};
  double ramp_s_ = 2.0;
};

}  // namespace

std::unique_ptr<Trajectory> make_my_trajectory() { return std::make_unique<MyTrajectory>(); }

}  // namespace gustlab
