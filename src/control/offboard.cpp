#include "control/offboard.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/attitude.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {
constexpr double longest_age_s = 0.5;  // a pose that is older counts as this old
}

void OffboardOptions::visit(ParameterVisitor& visitor) {
  visitor.text("low_level", low_level, {.help = low_level_help});
  visitor.number("rate_hz", rate_hz,
                 {.unit = "Hz", .help = "of the force law; divides the base rate", .min = 1.0, .max = 1000.0});
  visitor.number("delay_s", delay_s, {.unit = "s", .help = "age of what the force law sees", .min = 0.0, .max = 0.5});
  visitor.text("thrust_estimate", thrust_estimate,
               {.help = "thrust from the command, through the nominal rotor lag, or from the measured rotor_speed"});
  visitor.text("thrust_until", thrust_until,
               {.help = "the thrust beside a pose's acceleration is that up to its arrival, or up to its time stamp"});
  visitor.number("bandwidth_radps", bandwidth_radps,
                 {.unit = "rad/s",
                  .help = "of the position error, K_p = w²; 0: 0.27 of the attitude loop's",
                  .min = 0.0,
                  .max = 50.0});
  visitor.number("damping", damping, {.help = "K_v = 2 damping w", .min = 0.0, .max = 10.0});
  visitor.number("tilt_limit_deg", tilt_limit_deg,
                 {.unit = "deg", .help = "of the wanted attitude", .min = 1.0, .max = 80.0});
  visitor.flag("feedforward", feedforward,
               {.help = "the law is told velocity and acceleration of the reference; otherwise they count as zero"});
}

double OffboardFrame::base_rate_hz(const OffboardOptions& options, const VehicleModel& vehicle) const {
  return gustlab::base_rate_hz(low_level_of(options.low_level, vehicle));
}

OffboardSetup OffboardFrame::reset(const OffboardOptions& options, const ControllerSetup& setup,
                                   const Observation& first) {
  if (options.thrust_estimate != "command" && options.thrust_estimate != "rotor_speed")
    throw ParameterError("thrust_estimate",
                         "thrust_estimate = \"" + options.thrust_estimate +
                             "\" is unknown (where the thrust is known from); use command or rotor_speed");
  if (options.thrust_until != "arrival" && options.thrust_until != "stamp")
    throw ParameterError("thrust_until", "thrust_until = \"" + options.thrust_until +
                                             "\" is unknown (where an interval ends); use arrival or stamp");
  feedforward_ = options.feedforward;
  until_stamp_ = options.thrust_until == "stamp";
  from_rotor_speed_ = options.thrust_estimate == "rotor_speed";
  vehicle_ = setup.vehicle;
  mixer_ = Mixer(vehicle_);
  period_s_ = setup.period_s;
  const LowLevel kind = low_level_of(options.low_level, vehicle_);
  loop_ = make_low_level(kind, vehicle_, period_s_);
  loop_->reset(first);
  ticks_ = ticks_per_update("rate_hz", options.rate_hz, period_s_);
  tick_ = 0;
  tilt_limit_rad_ = options.tilt_limit_deg * pi / 180.0;
  const double w =
      options.bandwidth_radps > 0.0 ? options.bandwidth_radps : 0.27 * attitude_bandwidth(kind, vehicle_, period_s_);
  k_p_ = w * w;
  k_v_ = 2.0 * options.damping * w;

  impulse_W_Ns_ = pose_impulse_W_Ns_ = Vector3::Zero();
  pose_time_s_ = -std::numeric_limits<double>::infinity();
  past_impulses_W_Ns_.assign(static_cast<std::size_t>(std::lround(longest_age_s / period_s_)) + 1, Vector3::Zero());
  newest_ = present_ = 0;
  const auto delay_ticks = static_cast<std::size_t>(std::lround(options.delay_s / period_s_));
  ring_.assign(delay_ticks + 1, {first, Vector3::Zero()});
  const double lag_s = nominal_motor_lag_s(vehicle_);
  model_follows_ = lag_s > 0.0 ? 1.0 - std::exp(-period_s_ / lag_s) : 1.0;
  model_speed_radps_ = command_radps_ = first.rotor_speed_radps;
  last_.reset();
  acceleration_W_mps2_.setZero();
  thrust_W_N_ = vehicle_.weight_N() * Vector3::UnitZ();
  return {vehicle_, ticks_ * period_s_, w, options.damping, tilt_limit_rad_};
}

Vector3 OffboardFrame::impulse_until(double age_s) const {
  const std::size_t size = past_impulses_W_Ns_.size();
  const auto ticks = static_cast<std::size_t>(std::lround(std::clamp(age_s, 0.0, longest_age_s) / period_s_));
  return past_impulses_W_Ns_[(present_ + size - ticks) % size];
}

bool OffboardFrame::observe(const Observation& observation, const Reference& reference, OffboardInput& input) {
  // thrust of the period that ends now
  RotorArray& speed = model_speed_radps_;
  if (from_rotor_speed_) speed = observation.rotor_speed_radps;
  else
    for (std::size_t i = 0; i < speed.size(); ++i) speed[i] += model_follows_ * (command_radps_[i] - speed[i]);
  input.thrust_now_W_N = observation.attitude_WB * mixer_.force_B_N(speed);
  impulse_W_Ns_ += period_s_ * input.thrust_now_W_N;
  present_ = (present_ + 1) % past_impulses_W_Ns_.size();
  past_impulses_W_Ns_[present_] = impulse_W_Ns_;
  // poses may come more seldom than this is called: what counts is the thrust up to the pose
  if (observation.pose_time_s != pose_time_s_)
    pose_impulse_W_Ns_ = until_stamp_ ? impulse_until(observation.time_s - observation.pose_time_s) : impulse_W_Ns_;
  pose_time_s_ = observation.pose_time_s;
  newest_ = (newest_ + 1) % ring_.size();
  ring_[newest_] = {observation, pose_impulse_W_Ns_};

  const bool now = tick_ == 0;
  if (++tick_ == ticks_) tick_ = 0;
  if (!now) return false;

  // the oldest moment that is kept is as old as the delay
  const Moment& moment = ring_[(newest_ + 1) % ring_.size()];
  const Observation& seen = moment.observation;
  if (!last_) {
    last_ = moment;
  } else if (const double interval_s = seen.pose_time_s - last_->observation.pose_time_s; interval_s > 0.0) {
    acceleration_W_mps2_ = (seen.velocity_W_mps - last_->observation.velocity_W_mps) / interval_s;
    thrust_W_N_ = (moment.impulse_W_Ns - last_->impulse_W_Ns) / interval_s;
    last_ = moment;
  }

  input.time_s = observation.time_s;
  input.seen = seen;
  input.reference = reference;
  if (!feedforward_)
    input.reference.velocity_W_mps = input.reference.acceleration_W_mps2 = input.reference.jerk_W_mps3 =
        Vector3::Zero();
  input.position_error_W_m = seen.position_W_m - reference.position_W_m;
  input.velocity_error_W_mps = seen.velocity_W_mps - input.reference.velocity_W_mps;
  input.acceleration_command_W_mps2 =
      input.reference.acceleration_W_mps2 - k_p_ * input.position_error_W_m - k_v_ * input.velocity_error_W_mps;
  input.acceleration_W_mps2 = acceleration_W_mps2_;
  input.thrust_W_N = thrust_W_N_;
  input.age_s = observation.time_s - seen.pose_time_s;
  input.impulse_since_W_Ns = impulse_W_Ns_ - impulse_until(input.age_s);
  return true;
}

void OffboardFrame::command(const Vector3& force_W_N, const Quaternion& seen_attitude_WB, double yaw_rad) {
  const Vector3 force = tilt_limited(force_W_N, tilt_limit_rad_, 0.1 * vehicle_.weight_N());
  // along the present thrust axis: thrust waits for the attitude (Lee, Leok, McClamroch, CDC 2010)
  const double along_N = force.dot(seen_attitude_WB * Vector3::UnitZ());
  loop_->command({std::clamp(along_N, 0.0, 0.95 * mixer_.max_thrust_N()), attitude_along(force, yaw_rad)});
}

RotorCommand OffboardFrame::update(const Observation& observation) {
  const RotorCommand command = loop_->update(observation);
  command_radps_ = command.speed_radps;
  return command;
}

}  // namespace gustlab
