// battery_sag: thrust falls with the battery's voltage, or with time where the voltage is not known.
//
// f (V / V₀)^exponent, V₀ the nominal voltage; without voltage f (1 − rate t); reaction torque alike. Where the rotor speed
// is measured the speed that is reached falls instead, with half the exponent. Podhradský et al., ICUAS 2013.
#include <algorithm>
#include <cmath>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class BatterySag final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("exponent", exponent_,
                   {.unit = "-",
                    .help = "thrust goes with this power of the voltage, where it is known",
                    .min = -5.0,
                    .max = 5.0,
                    .natural = 0.5,
                    .fitted = Fitted::with_voltage});
    visitor.number("rate", rate_ps_,
                   {.unit = "1/s",
                    .help = "share of thrust lost per second of flight, where voltage is not known",
                    .min = 0.0,
                    .max = 0.1,
                    .natural = 0.002,
                    .fitted = Fitted::without_voltage});
  }

  void on_actuation(Actuation& actuation) const override {
    if (!actuation.speed_is_measured) return;
    const double factor = std::sqrt(thrust_factor(actuation.time_s, actuation.voltage_V));
    for (std::size_t i = 0; i < static_cast<std::size_t>(actuation.count); ++i)
      actuation.set_command(i, factor * actuation.command_radps[i]);
  }

  void prepare(const VehicleModel& vehicle, double, const RandomStream&) override {
    nominal_V_ = vehicle.nominal_voltage_V;
  }

  void on_rotor(Flow& flow, RotorSet& rotors) const override {
    if (flow.speed_is_measured) return;
    const double factor = thrust_factor(flow.time_s, flow.voltage_V);
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) {
      rotors.thrust_N[i] *= factor;
      rotors.reaction_Nm[i] *= factor;
    }
  }

 private:
  double thrust_factor(double time_s, double voltage_V) const {
    if (voltage_V > 0.0 && nominal_V_ > 0.0) return std::pow(voltage_V / nominal_V_, exponent_);
    return std::max(0.0, 1.0 - rate_ps_ * time_s);
  }

  double exponent_ = 0.0, rate_ps_ = 0.0;
  double nominal_V_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_battery_sag() { return std::make_unique<BatterySag>(); }

}  // namespace gustlab
