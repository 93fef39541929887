// indi: incremental inversion of attitude and acceleration, all at the base rate, from accelerometer and gyroscope.
//
// law firmware is the Crazyflie's (PAPER constants in control/indi.cpp); flatness feeds the reference's acceleration forward
// and works on the force vector. inner indi is the firmware's inner loop, low_level the vehicle's usual loops.
#include "control/indi.hpp"

#include "controllers/controllers.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

class Indi final : public Controller {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.text("low_level", low_level_, {.help = low_level_help});
    visitor.text("law", law_, {.help = "outer loop: firmware (Crazyflie) or flatness (Tal & Karaman)"});
    visitor.text("inner", inner_,
                 {.help = "inner loop: indi, or low_level for the vehicle's usual attitude and rate loops"});
    visitor.number("position_gain", options_.position_gain,
                   {.unit = "1/s", .help = "velocity per position error (firmware law)", .min = 0.0, .max = 50.0});
    visitor.number("velocity_gain", options_.velocity_gain,
                   {.unit = "1/s", .help = "acceleration per velocity error (firmware law)", .min = 0.0, .max = 50.0});
    visitor.number("attitude_gain", options_.attitude_gain,
                   {.unit = "1/s", .help = "rate per attitude error", .min = 0.0, .max = 50.0});
    visitor.number("rate_gain", options_.rate_gain,
                   {.unit = "1/s", .help = "angular acceleration per rate error", .min = 0.1, .max = 200.0});
    visitor.number("filter_hz", options_.filter_hz,
                   {.unit = "Hz",
                    .help = "second-order filter of sensors and actuators; 0, or from half of the rate on: none",
                    .min = 0.0,
                    .max = 1000.0});
    visitor.number("bandwidth_radps", bandwidth_radps_,
                   {.unit = "rad/s",
                    .help = "of the position error, K_p = w² (flatness law); 0: 0.27 of the attitude gain",
                    .min = 0.0,
                    .max = 50.0});
    visitor.number("damping", damping_, {.help = "K_v = 2 damping w (flatness law)", .min = 0.0, .max = 100.0});
    visitor.number("tilt_limit_deg", tilt_limit_deg_,
                   {.unit = "deg",
                    .help = "0: 10 (the Crazyflie firmware's clamp), 30 on other vehicles and in flatness",
                    .min = 0.0,
                    .max = 80.0});
  }

  double rate_hz(const VehicleModel& vehicle) const override { return base_rate_hz(low_level_of(low_level_, vehicle)); }
  bool uses_accelerometer() const override { return true; }

  void reset(const ControllerSetup& setup, const Observation& first) override {
    if (law_ != "firmware" && law_ != "flatness")
      throw ParameterError("law", "law = \"" + law_ + "\" is unknown (which outer loop); use firmware or flatness");
    if (inner_ != "indi" && inner_ != "low_level")
      throw ParameterError("inner", "inner = \"" + inner_ + "\" is unknown (which inner loop); use indi or low_level");
    flatness_ = law_ == "flatness";
    const LowLevel kind = low_level_of(low_level_, setup.vehicle);
    IndiOptions options = scaled(options_, setup.vehicle, kind, setup.period_s);
    if (flatness_ || kind != LowLevel::crazyflie) options.tilt_limit_rad = 30.0 * pi / 180.0;
    if (tilt_limit_deg_ > 0.0) options.tilt_limit_rad = tilt_limit_deg_ * pi / 180.0;

    if (flatness_) {
      const double w = bandwidth_radps_ > 0.0 ? bandwidth_radps_ : 0.27 * options.attitude_gain;
      force_ = IndiForce(setup.vehicle, options, w, damping_, setup.period_s);
      force_.reset(first);
    } else {
      position_ = IndiPosition(setup.vehicle, kind, options, setup.period_s);
      position_.reset(first);
    }
    loop_.reset();
    if (inner_ == "low_level") {
      loop_ = make_low_level(kind, setup.vehicle, setup.period_s);
      loop_->reset(first);
    } else {
      attitude_ = IndiAttitude(setup.vehicle, kind, options, setup.period_s);
      attitude_.reset(first);
    }
  }

  RotorCommand update(const Observation& observation, const Reference& reference) override {
    const ThrustAttitude wanted =
        flatness_ ? force_.update(observation, reference) : position_.update(observation, reference);
    if (loop_) loop_->command(wanted);
    const RotorCommand command = loop_ ? loop_->update(observation) : attitude_.update(observation, wanted);
    if (flatness_) force_.flown(command);
    return command;
  }

 private:
  std::string low_level_ = "auto", law_ = "firmware", inner_ = "indi";
  IndiOptions options_;
  double bandwidth_radps_ = 0.0, damping_ = 1.0, tilt_limit_deg_ = 0.0;

  bool flatness_ = false;
  IndiPosition position_;
  IndiForce force_;
  IndiAttitude attitude_;
  std::unique_ptr<LowLevelLoop> loop_;
};

}  // namespace

std::unique_ptr<Controller> make_indi() { return std::make_unique<Indi>(); }

}  // namespace gustlab
