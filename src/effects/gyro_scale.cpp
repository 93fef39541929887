// gyro_scale: the gyroscope reads (1 + delta) times the body rate.
//
// Scale factor error of MEMS gyroscopes: IEEE Std 1431. Parts scatter by 1 % (BMI088 data sheet, sensitivity tolerance); half of that is
// calibration.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class GyroScale final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("delta", delta_,
                   {.unit = "-",
                    .help = "relative error of the measured body rate",
                    .min = -0.25,
                    .max = 0.25,
                    .natural = 0.01,
                    .tolerance = 0.005,
                    .estimate_tolerance = 0.01});
  }

  void on_measurement(const MeasurementContext&, Measured& measured) const override {
    measured.body_rate_B_radps *= 1.0 + delta_;
  }

 private:
  double delta_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_gyro_scale() { return std::make_unique<GyroScale>(); }

}  // namespace gustlab
