// actuation_delay: the rotors obey what was asked for a while ago.
//
// u(t − delay), as the mean over the step, so that a delay far below one step still shows. Transport lag:
// Åström, Murray, Feedback Systems, 2008, §8.1.
#include <algorithm>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class ActuationDelay final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("delay", delay_s_,
                   {.unit = "s",
                    .help = "from command to rotor",
                    .min = 0.0,
                    .max = 1.0,
                    .natural = 0.005,
                    .tolerance = 0.003,
                    .plausible = 0.15});
  }

  void prepare(const VehicleModel& vehicle, double, const RandomStream&) override {
    max_speed_radps_ = vehicle.max_speed_radps;
  }
  double lookback_s() const override { return delay_s_; }

  void on_actuation(Actuation& actuation) const override {
    if (delay_s_ == 0.0 || actuation.past == nullptr) return;
    RotorArray late_radps;
    actuation.past->command(delay_s_, late_radps);
    for (std::size_t i = 0; i < static_cast<std::size_t>(actuation.count); ++i)
      actuation.set_command(i, std::clamp(late_radps[i], 0.0, max_speed_radps_));
  }

 private:
  double delay_s_ = 0.0;
  double max_speed_radps_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_actuation_delay() { return std::make_unique<ActuationDelay>(); }

}  // namespace gustlab
