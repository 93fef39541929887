// yaw_offset: the logged heading is turned against the body: markers or magnetometer mounted askew.
//
// R_log = R exp(δ), δ = (0, 0, z).
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class YawOffset final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number(
        "z", z_rad_,
        {.unit = "rad", .help = "yaw of the logged frame against the body", .min = -pi, .max = pi, .natural = 0.01});
  }

  void on_measurement(const MeasurementContext&, Measured& measured) const override {
    if (z_rad_ == 0.0) return;
    measured.attitude_WB = measured.attitude_WB * Quaternion(Eigen::AngleAxisd(z_rad_, Vector3::UnitZ()));
  }

 private:
  double z_rad_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_yaw_offset() { return std::make_unique<YawOffset>(); }

}  // namespace gustlab
