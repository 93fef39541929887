// steady_wind: the air itself moves; every effect that feels the air feels it, and nothing else does.
//
// v_r = Rᵀ(v − wind). Alone it does nothing: it acts through rotor_drag, quadratic_drag, axial_inflow, lift and flapping.
// Tomić, Schmid, Lutz, Mathers, Haddadin, IROS 2016 (the flying anemometer).
// Beforehand no wind reaches hurricane force (32.7 m/s, Beaufort's 12), and its mean over a flight is nearly level: the vertical component has a
// standard deviation of 1.25 u* with u* below a tenth of the wind speed (Kaimal and Finnigan, Atmospheric Boundary Layer Flows, 1994, ch. 1).
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class SteadyWind final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("x", wind_W_mps_.x(),
                   {.unit = "m/s", .help = "wind toward world x", .natural = 1.0, .plausible = 30.0});
    visitor.number("y", wind_W_mps_.y(),
                   {.unit = "m/s", .help = "wind toward world y", .natural = 1.0, .plausible = 30.0});
    visitor.number(
        "z", wind_W_mps_.z(),
        {.unit = "m/s", .help = "wind toward world z (up)", .natural = 1.0, .plausible = 5.0, .known_to = 1.0});
  }

  void on_rotor(Flow& flow, RotorSet&) const override {
    if (wind_W_mps_.isZero(0.0)) return;
    flow.air_velocity_B_mps -= flow.R_WB.transpose() * wind_W_mps_;
  }

 private:
  Vector3 wind_W_mps_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Effect> make_steady_wind() { return std::make_unique<SteadyWind>(); }

}  // namespace gustlab
