// pid: the position cascade that the vehicle's firmware flies, over the same firmware's attitude and rate loops.
//
// Crazyflie: position 100 Hz, attitude and rate 500 Hz, no velocity feed-forward in position mode. ArduPilot: everything at
// 400 Hz, with the target's velocity and acceleration fed forward. Any other vehicle: the ArduPilot structure with gains
// from the bandwidth of its own attitude loop.
#include "control/low_level.hpp"
#include "control/position_pid.hpp"
#include "controllers/controllers.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr double degree = pi / 180.0;

class PidController final : public Controller {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.text("low_level", low_level_, {.help = low_level_help});
    visitor.number("rate_hz", rate_hz_,
                   {.unit = "Hz", .help = "of the position loop; 0: the firmware's", .min = 0.0, .max = 1000.0});
    visitor.number("position_gain", position_gain_,
                   {.help = "times the firmware's position gain", .min = 0.0, .max = 20.0});
    visitor.number("velocity_gain", velocity_gain_,
                   {.help = "times the firmware's velocity gain", .min = 0.0, .max = 20.0});
    visitor.number("integral_gain", integral_gain_,
                   {.help = "times the firmware's integral gains", .min = 0.0, .max = 1000.0});
    visitor.number("tilt_limit_deg", tilt_limit_deg_,
                   {.unit = "deg", .help = "0: the firmware's", .min = 0.0, .max = 80.0});
    visitor.text("feedforward", feedforward_,
                 {.help = "of the reference: firmware (Crazyflie none, others full), none, velocity, full"});
  }

  double rate_hz(const VehicleModel& vehicle) const override { return base_rate_hz(low_level_of(low_level_, vehicle)); }

  void reset(const ControllerSetup& setup, const Observation& first) override {
    const LowLevel kind = low_level_of(low_level_, setup.vehicle);
    crazyflie_ = kind == LowLevel::crazyflie;
    const double firmware_rate_hz = crazyflie_ ? 100.0 : kind == LowLevel::ardupilot ? 400.0 : 100.0;
    ticks_ = ticks_per_update("rate_hz", rate_hz_ > 0.0 ? rate_hz_ : firmware_rate_hz, setup.period_s);
    const double period_s = ticks_ * setup.period_s;
    const FeedForward feedforward = feed_forward(crazyflie_);
    if (crazyflie_) {
      CrazyfliePosition::Options options{position_gain_, velocity_gain_, integral_gain_};
      if (tilt_limit_deg_ > 0.0) options.tilt_limit_rad = tilt_limit_deg_ * degree;
      options.feedforward = feedforward;
      crazyflie_position_ = CrazyfliePosition(setup.vehicle, options, period_s);
    } else {
      ForcePosition::Options options;
      if (kind == LowLevel::generic) options = generic(attitude_bandwidth(kind, setup.vehicle, setup.period_s));
      options.position_xy_p *= position_gain_;
      options.position_z_p *= position_gain_;
      options.velocity_xy_p *= velocity_gain_;
      options.velocity_z_p *= velocity_gain_;
      options.velocity_xy_i *= integral_gain_;
      options.velocity_z_i *= integral_gain_;
      if (tilt_limit_deg_ > 0.0) options.tilt_limit_rad = tilt_limit_deg_ * degree;
      options.feedforward = feedforward;
      force_position_ = ForcePosition(setup.vehicle, options, period_s);
    }
    loop_ = make_low_level(kind, setup.vehicle, setup.period_s);
    loop_->reset(first);
    tick_ = 0;
  }

  RotorCommand update(const Observation& observation, const Reference& reference) override {
    if (tick_ == 0)
      loop_->command(crazyflie_ ? crazyflie_position_.update(observation, reference)
                                : force_position_.update(observation, reference));
    if (++tick_ == ticks_) tick_ = 0;
    return loop_->update(observation);
  }

 private:
  FeedForward feed_forward(bool crazyflie) const {
    if (feedforward_ == "firmware") return crazyflie ? FeedForward::none : FeedForward::full;
    if (feedforward_ == "none") return FeedForward::none;
    if (feedforward_ == "velocity") return FeedForward::velocity;
    if (feedforward_ == "full") return FeedForward::full;
    throw ParameterError(
        "feedforward",
        "feedforward = \"" + feedforward_ +
            "\" is unknown (what of the reference is fed forward); use firmware, none, velocity or full");
  }

  // each loop a third as fast as the one below it
  static ForcePosition::Options generic(double attitude_radps) {
    ForcePosition::Options options;
    const double velocity = attitude_radps / 3.0;
    options.velocity_xy_p = velocity;
    options.velocity_xy_i = velocity * velocity / 4.0;
    options.velocity_xy_d = 0.0;
    options.velocity_z_p = velocity;
    options.velocity_z_i = velocity * velocity / 2.0;
    options.position_xy_p = options.position_z_p = velocity / 2.5;
    options.error_cutoff_hz = 0.0;
    return options;
  }

  std::string low_level_ = "auto";
  double rate_hz_ = 0.0;
  double position_gain_ = 1.0, velocity_gain_ = 1.0, integral_gain_ = 1.0;
  double tilt_limit_deg_ = 0.0;
  std::string feedforward_ = "firmware";

  bool crazyflie_ = false;
  CrazyfliePosition crazyflie_position_;
  ForcePosition force_position_;
  std::unique_ptr<LowLevelLoop> loop_;
  int ticks_ = 1, tick_ = 0;
};

}  // namespace

std::unique_ptr<Controller> make_pid() { return std::make_unique<PidController>(); }

}  // namespace gustlab
