// rotor_loss: one rotor has lost a share of its thrust, and of its reaction torque: a nicked blade, a tired motor.
//
// f (1 − loss). Loss of effectiveness: Freddi, Lanzon, Longhi, IFAC 2011. Plausible: the best of four rotors pushes no 30 % more than the file says.
#include <fmt/format.h>

#include "effects/effects.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

class RotorLoss final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.integer("rotor", rotor_, {.unit = "-", .help = "which rotor, from 1", .min = 1, .max = max_rotors});
    visitor.number("loss", loss_,
                   {.unit = "-",
                    .help = "share of thrust and reaction torque that is lost; < 0: it pushes more",
                    .min = -10.0,
                    .max = 1.0,
                    .natural = 0.05,
                    .tolerance = 0.01,
                    .plausible = 1.0,
                    .plausible_from = -0.3});
  }

  void prepare(const VehicleModel& vehicle, double, const RandomStream&) override {
    if (rotor_ > vehicle.rotor_count)
      throw ParameterError("rotor", fmt::format("rotor_loss: no rotor {} (the vehicle has {}); use 1 to {}", rotor_,
                                                vehicle.rotor_count, vehicle.rotor_count));
  }

  void on_rotor(Flow&, RotorSet& rotors) const override {
    const auto i = static_cast<std::size_t>(rotor_ - 1);
    rotors.thrust_N[i] *= 1.0 - loss_;
    rotors.reaction_Nm[i] *= 1.0 - loss_;
  }

 private:
  std::int64_t rotor_ = 1;
  double loss_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_rotor_loss() { return std::make_unique<RotorLoss>(); }

}  // namespace gustlab
