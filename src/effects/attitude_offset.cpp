// attitude_offset: the logged attitude is tilted against the body: markers, a level that was never calibrated.
//
// R_log = R exp(δ), δ = (x, y, 0). Exact alias of rotor_tilt in translation.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class AttitudeOffset final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("x", x_rad_,
                   {.unit = "rad",
                    .help = "roll of the logged frame against the body",
                    .min = -0.5,
                    .max = 0.5,
                    .natural = 0.01,
                    .plausible = 0.2});
    visitor.number("y", y_rad_,
                   {.unit = "rad",
                    .help = "pitch of the logged frame against the body",
                    .min = -0.5,
                    .max = 0.5,
                    .natural = 0.01,
                    .plausible = 0.2});
  }

  void on_measurement(const MeasurementContext&, Measured& measured) const override {
    if (x_rad_ == 0.0 && y_rad_ == 0.0) return;
    const Vector3 turn(x_rad_, y_rad_, 0.0);
    measured.attitude_WB = measured.attitude_WB * Quaternion(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  }

 private:
  double x_rad_ = 0.0, y_rad_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_attitude_offset() { return std::make_unique<AttitudeOffset>(); }

}  // namespace gustlab
