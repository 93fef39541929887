// imu_lever: the accelerometer does not sit at the body's origin.
//
// a + ω̇ × l + ω × (ω × l), l = (x, y, z) from the body's origin. Rigid-body kinematics.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class ImuLever final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    constexpr double natural = 0.1;  // of the arm
    visitor.number("x", lever_B_m_.x(),
                   {.unit = "m", .help = "forward of the body's origin", .natural = natural, .scale = Scale::arm});
    visitor.number("y", lever_B_m_.y(),
                   {.unit = "m", .help = "left of the body's origin", .natural = natural, .scale = Scale::arm});
    visitor.number("z", lever_B_m_.z(),
                   {.unit = "m", .help = "above the body's origin", .natural = natural, .scale = Scale::arm});
  }

  void on_measurement(const MeasurementContext& context, Measured& measured) const override {
    if (lever_B_m_.isZero(0.0)) return;
    const Vector3& rate = measured.body_rate_B_radps;
    measured.specific_force_B_mps2 +=
        context.angular_acceleration_B_radps2.cross(lever_B_m_) + rate.cross(rate.cross(lever_B_m_));
  }

 private:
  Vector3 lever_B_m_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Effect> make_imu_lever() { return std::make_unique<ImuLever>(); }

}  // namespace gustlab
