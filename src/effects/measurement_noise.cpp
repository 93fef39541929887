// measurement_noise: white noise and constant biases on what the sensors say; for the simulator only.
//
// Noise is a function of seed, replicate and observation alone: every controller meets the same. IEEE Std 1431.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class MeasurementNoise final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    const auto deviation = [&visitor](std::string_view name, double& value, std::string_view unit,
                                      std::string_view help) {
      visitor.number(name, value, {.unit = unit, .help = help, .min = 0.0, .natural = 0.0});
    };
    deviation("position_sd", position_sd_m_, "m", "standard deviation per axis");
    deviation("velocity_sd", velocity_sd_mps_, "m/s", "standard deviation per axis");
    deviation("attitude_sd", attitude_sd_rad_, "rad", "standard deviation of the turn about each body axis");
    deviation("rate_sd", rate_sd_radps_, "rad/s", "standard deviation per axis of the gyroscope");
    deviation("accelerometer_sd", accelerometer_sd_mps2_, "m/s^2", "standard deviation per axis");
    visitor.vector("rate_bias", rate_bias_radps_,
                   {.unit = "rad/s", .help = "constant error of the gyroscope", .natural = 0.0});
    visitor.vector("accelerometer_bias", accelerometer_bias_mps2_,
                   {.unit = "m/s^2", .help = "constant error of the accelerometer", .natural = 0.0});
  }

  void prepare(const VehicleModel&, double, const RandomStream& stream) override { stream_ = stream; }

  void on_measurement(const MeasurementContext& context, Measured& measured) const override {
    const auto counter = static_cast<std::uint64_t>(context.tick);
    // one lane of the stream per sensor, so that switching one on leaves the others as they were
    const auto noise = [this, counter](std::uint32_t lane, double deviation) -> Vector3 {
      const auto normal = stream_.normal4(counter, lane);
      return deviation * Vector3(normal[0], normal[1], normal[2]);
    };
    if (position_sd_m_ > 0.0) measured.position_W_m += noise(0, position_sd_m_);
    if (velocity_sd_mps_ > 0.0) measured.velocity_W_mps += noise(1, velocity_sd_mps_);
    if (attitude_sd_rad_ > 0.0) {
      const Vector3 turn = noise(2, attitude_sd_rad_);
      measured.attitude_WB = measured.attitude_WB * Quaternion(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    }
    if (rate_sd_radps_ > 0.0) measured.body_rate_B_radps += noise(3, rate_sd_radps_);
    if (accelerometer_sd_mps2_ > 0.0) measured.specific_force_B_mps2 += noise(4, accelerometer_sd_mps2_);
    if (!rate_bias_radps_.isZero(0.0)) measured.body_rate_B_radps += rate_bias_radps_;
    if (!accelerometer_bias_mps2_.isZero(0.0)) measured.specific_force_B_mps2 += accelerometer_bias_mps2_;
  }

 private:
  double position_sd_m_ = 0.0, velocity_sd_mps_ = 0.0, attitude_sd_rad_ = 0.0, rate_sd_radps_ = 0.0;
  double accelerometer_sd_mps2_ = 0.0;
  Vector3 rate_bias_radps_ = Vector3::Zero(), accelerometer_bias_mps2_ = Vector3::Zero();
  RandomStream stream_;
};

}  // namespace

std::unique_ptr<Effect> make_measurement_noise() { return std::make_unique<MeasurementNoise>(); }

}  // namespace gustlab
