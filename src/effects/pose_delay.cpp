// pose_delay: position, velocity and attitude in the log are older than the inertial data beside them.
//
// y(t − delay). Latency of motion capture and its radio.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class PoseDelay final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("delay", delay_s_,
                   {.unit = "s",
                    .help = "age of pose and velocity",
                    .min = 0.0,
                    .max = 1.0,
                    .natural = 0.005,
                    .tolerance = 0.003});
  }

  double lookback_s() const override { return delay_s_; }

  void on_measurement(const MeasurementContext& context, Measured& measured) const override {
    if (delay_s_ == 0.0 || context.past == nullptr) return;
    const VehicleState past = context.past->at(context.time_s - delay_s_);
    measured.position_W_m = past.position_W_m;
    measured.velocity_W_mps = past.velocity_W_mps;
    measured.attitude_WB = past.attitude_WB;
  }

 private:
  double delay_s_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_pose_delay() { return std::make_unique<PoseDelay>(); }

}  // namespace gustlab
