// motor_lag: rotor speed follows its command as a first-order lag, faster up than down where the vehicle says so.
//
// Ω̇ = (Ω_c − Ω)/τ, solved exactly over a step of constant command; the air feels the mean speed of the step, so that the
// effect is differentiable at τ = 0.
#include <cmath>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class MotorLag final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("time_constant", up_s_,
                   {.unit = "s",
                    .help = "time constant while the speed rises",
                    .min = 0.0,
                    .max = 1.0,
                    .natural = 0.01,
                    .tolerance = 0.004});
    visitor.number("time_constant_down", down_s_,
                   {.unit = "s",
                    .help = "time constant while the speed falls; negative: as when it rises",
                    .min = -1.0,
                    .max = 1.0,
                    .natural = 0.01,
                    .tolerance = 0.004,
                    .fitted = Fitted::unless_negative});
  }

  void prepare(const VehicleModel&, double step_s, const RandomStream&) override {
    step_s_ = step_s;
    prepared_ = over(step_s);
  }

  void on_actuation(Actuation& actuation) const override {
    // the rows of a log may be anything apart
    const bool as_prepared = std::abs(actuation.step_s - step_s_) <= 1e-3 * step_s_;
    const auto [up, down] = as_prepared ? prepared_ : over(actuation.step_s);
    for (std::size_t i = 0; i < static_cast<std::size_t>(actuation.count); ++i) {
      const double gap = actuation.start_speed_radps[i] - actuation.command_radps[i];
      const Response& r = gap > 0.0 ? down : up;
      if (r.mean == 0.0) continue;
      actuation.end_speed_radps[i] = actuation.command_radps[i] + gap * r.end;
      actuation.mean_speed_radps[i] = actuation.command_radps[i] + gap * r.mean;
    }
  }

 private:
  // what is left of a gap at the end of a step, and on its average
  struct Response {
    double end = 0.0, mean = 0.0;
  };
  struct BothWays {
    Response up, down;
  };
  BothWays over(double step_s) const {
    return {response(up_s_, step_s), response(down_s_ < 0.0 ? up_s_ : down_s_, step_s)};
  }
  static Response response(double tau_s, double step_s) {
    if (tau_s <= 0.0) return {};
    const double end = std::exp(-step_s / tau_s);
    return {end, (1.0 - end) * tau_s / step_s};
  }

  double up_s_ = 0.0, down_s_ = -1.0;
  double step_s_ = 0.0;
  BothWays prepared_;  // over that step
};

}  // namespace

std::unique_ptr<Effect> make_motor_lag() { return std::make_unique<MotorLag>(); }

}  // namespace gustlab
