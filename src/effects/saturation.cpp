// saturation: a rotor turns no faster than it can, and does not turn at all below a least command.
//
// Ω_c clipped to max_speed; 0 below dead_zone of the range. Faessler, Falanga, Scaramuzza, RA-L 2(2) 2017.
#include <algorithm>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class Saturation final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("max_speed", max_speed_radps_,
                   {.unit = "rad/s", .help = "fastest speed; 0: the vehicle file's", .min = 0.0, .natural = 100.0});
    visitor.number("dead_zone", dead_zone_,
                   {.unit = "-",
                    .help = "share of the range below which a rotor stands",
                    .min = 0.0,
                    .max = 1.0,
                    .natural = 0.05,
                    .fitted = Fitted::never});
  }

  void prepare(const VehicleModel& vehicle, double, const RandomStream&) override {
    limit_radps_ = max_speed_radps_ > 0.0 ? max_speed_radps_ : vehicle.max_speed_radps;
  }

  void on_actuation(Actuation& actuation) const override {
    for (std::size_t i = 0; i < static_cast<std::size_t>(actuation.count); ++i) {
      const double asked_radps = actuation.command_radps[i];
      if (asked_radps < dead_zone_ * limit_radps_) actuation.set_command(i, 0.0);
      if (asked_radps > limit_radps_) actuation.set_command(i, limit_radps_);
    }
  }

 private:
  double max_speed_radps_ = 0.0, dead_zone_ = 0.0;
  double limit_radps_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_saturation() { return std::make_unique<Saturation>(); }

}  // namespace gustlab
