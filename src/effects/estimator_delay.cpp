// estimator_delay: what the vehicle's own estimator says of each stream is older than now.
//
// y(t − delay), stream by stream. A position that comes over a radio is late by the link (offboard_delay_s of an experiment); what
// is late here is the filter aboard: attitude and body rate are late by milliseconds, because the loops that use them are quick.
#include <algorithm>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class EstimatorDelay final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    const auto delay = [&visitor](std::string_view name, double& value, std::string_view help) {
      visitor.number(name, value, {.unit = "s", .help = help, .min = 0.0, .max = 1.0, .natural = 0.0});
    };
    delay("position", position_s_, "age of the position");
    delay("velocity", velocity_s_, "age of the velocity");
    delay("attitude", attitude_s_, "age of the attitude");
    delay("body_rate", body_rate_s_, "age of the body rate");
  }

  double lookback_s() const override { return std::max({position_s_, velocity_s_, attitude_s_, body_rate_s_}); }

  void on_measurement(const MeasurementContext& context, Measured& measured) const override {
    if (context.past == nullptr) return;
    const auto late = [&](double delay_s, auto& stream, auto VehicleState::*value) {
      if (delay_s > 0.0) stream = context.past->at(context.time_s - delay_s).*value;
    };
    late(position_s_, measured.position_W_m, &VehicleState::position_W_m);
    late(velocity_s_, measured.velocity_W_mps, &VehicleState::velocity_W_mps);
    late(attitude_s_, measured.attitude_WB, &VehicleState::attitude_WB);
    late(body_rate_s_, measured.body_rate_B_radps, &VehicleState::body_rate_B_radps);
  }

 private:
  double position_s_ = 0.0, velocity_s_ = 0.0, attitude_s_ = 0.0, body_rate_s_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_estimator_delay() { return std::make_unique<EstimatorDelay>(); }

}  // namespace gustlab
