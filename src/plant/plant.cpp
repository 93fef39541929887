#include "plant/plant.hpp"

#include <cmath>

#include "plant/past.hpp"
#include "plant/rigid_body.hpp"

namespace gustlab {

namespace {

// a state as numbers: time, position, velocity, attitude (w last, as Eigen stores it), body rate, rotor speeds
constexpr std::size_t packed_size = 1 + 3 + 3 + 4 + 3 + max_rotors;
using Packed = std::array<double, packed_size>;

Packed pack(const VehicleState& state) {
  Packed packed;
  double* out = packed.data();
  *out++ = state.time_s;
  out = std::copy_n(state.position_W_m.data(), 3, out);
  out = std::copy_n(state.velocity_W_mps.data(), 3, out);
  out = std::copy_n(state.attitude_WB.coeffs().data(), 4, out);
  out = std::copy_n(state.body_rate_B_radps.data(), 3, out);
  std::copy(state.rotor_speed_radps.begin(), state.rotor_speed_radps.end(), out);
  return packed;
}

VehicleState unpack(const Packed& packed) {
  VehicleState state;
  const double* in = packed.data();
  state.time_s = in[0];
  state.position_W_m = Vector3(in + 1);
  state.velocity_W_mps = Vector3(in + 4);
  state.attitude_WB.coeffs() = Eigen::Vector4d(in + 7);
  state.body_rate_B_radps = Vector3(in + 11);
  std::copy_n(in + 14, max_rotors, state.rotor_speed_radps.begin());
  return state;
}

}  // namespace

struct Plant::Memory final : Actuation::Past, MeasurementContext::Past {
  Memory(const VehicleModel& vehicle, double lookback_s, double step_s)
      : body(vehicle, step_s), commands(lookback_s, step_s), poses(lookback_s, step_s) {}

  void command(double age_s, RotorArray& speed_radps) const override { speed_radps = commands.before(age_s); }
  VehicleState at(double time_s) const override {
    VehicleState state = unpack(poses.before(now_s - time_s));
    state.attitude_WB.normalize();
    return state;
  }

  RigidBody body;
  gustlab::Past<max_rotors> commands;
  gustlab::Past<packed_size> poses;
  double now_s = 0.0;
};

Plant::Plant(const VehicleModel& nominal, std::vector<NamedEffect> effects, const Options& options)
    : options_(options), forces_(nominal, std::move(effects)) {
  forces_.prepare(options.step_s, options.seed, options.replicate);
  forces_.set_speed_is_measured(options.speed_is_logged);
  remembers_ = forces_.lookback_s() > 0.0;
  memory_ = std::make_unique<Memory>(forces_.vehicle(), forces_.lookback_s(), options.step_s);
  effect_state_.resize(static_cast<std::size_t>(forces_.state_size()));
  reset(VehicleState{});
}

Plant::~Plant() = default;

void Plant::reset(const VehicleState& state) {
  steps_ = observations_ = 0;
  start_time_s_ = state.time_s;
  forces_.reset_state(effect_state_);
  rotor_acceleration_radps2_.fill(0.0);
  finite_ = true;
  memory_->body.forget();
  set_state(state);
  memory_->commands.fill(state.rotor_speed_radps);
  memory_->poses.fill(pack(state_));
}

void Plant::set_state(const VehicleState& state) {
  const double time_s = state_.time_s;
  state_ = state;
  if (steps_ > 0) state_.time_s = time_s;
  memory_->now_s = state_.time_s;
}

void Plant::actuate(const RotorCommand& command) {
  if (remembers_) memory_->commands.push(command.speed_radps);
  actuation_.time_s = state_.time_s;
  actuation_.step_s = options_.step_s;
  actuation_.voltage_V = voltage_V_;
  actuation_.command_radps = command.speed_radps;
  actuation_.start_speed_radps = state_.rotor_speed_radps;
  actuation_.past = memory_.get();
  if (speed_is_measured_) actuation_.end_speed_radps = actuation_.mean_speed_radps = command.speed_radps;
  else forces_.actuate(actuation_);
  for (std::size_t i = 0; i < static_cast<std::size_t>(forces_.vehicle().rotor_count); ++i)
    rotor_acceleration_radps2_[i] = (actuation_.end_speed_radps[i] - actuation_.start_speed_radps[i]) / options_.step_s;
}

Flow Plant::evaluate(const RotorArray& speed_radps) {
  Flow flow = forces_.flow(state_, voltage_V_);
  forces_.rotors(speed_radps, rotor_acceleration_radps2_, flow, rotors_);
  return flow;
}

bool Plant::step(const RotorCommand& command) {
  if (!finite_) return false;
  actuate(command);
  const Flow flow = evaluate(actuation_.mean_speed_radps);
  const Wrench wrench = forces_.wrench(flow, rotors_, effect_state_);
  if (!effect_state_.empty()) forces_.advance(flow, rotors_, wrench, effect_state_);
  finite_ = memory_->body.step(flow, wrench, state_);
  ++steps_;
  state_.rotor_speed_radps = actuation_.end_speed_radps;
  // time is counted, never accumulated
  state_.time_s = start_time_s_ + static_cast<double>(steps_) * options_.step_s;
  memory_->now_s = state_.time_s;
  if (remembers_) memory_->poses.push(pack(state_));
  return finite_;
}

void Plant::advance_actuation(const RotorCommand& command) {
  actuate(command);
  state_.rotor_speed_radps = actuation_.end_speed_radps;
}

void Plant::set_speed_is_measured(bool measured) {
  speed_is_measured_ = measured;
  forces_.set_speed_is_measured(measured);
}

bool Plant::touches_ground() const { return memory_->body.contacts() > 0; }

Observation Plant::observe(bool with_accelerometer) {
  Measured measured{state_.position_W_m, state_.velocity_W_mps, state_.attitude_WB, state_.body_rate_B_radps, {}};
  measured.specific_force_B_mps2.setZero();
  MeasurementContext context;
  context.time_s = state_.time_s;
  context.tick = observations_++;
  context.past = memory_.get();
  if (with_accelerometer) {
    const Flow flow = evaluate(state_.rotor_speed_radps);
    const Wrench wrench = forces_.wrench(flow, rotors_, effect_state_);
    context.angular_acceleration_B_radps2 = forces_.acceleration(flow, wrench).angular_B_radps2;
    // at the body's origin, where the accelerometer sits
    measured.specific_force_B_mps2 =
        forces_.specific_force_at_origin(flow, wrench, context.angular_acceleration_B_radps2);
  }
  forces_.measure(context, measured);

  Observation seen;
  seen.time_s = seen.pose_time_s = seen.inertial_time_s = state_.time_s;
  seen.position_W_m = measured.position_W_m;
  seen.velocity_W_mps = measured.velocity_W_mps;
  seen.attitude_WB = measured.attitude_WB;
  seen.body_rate_B_radps = measured.body_rate_B_radps;
  seen.specific_force_B_mps2 = measured.specific_force_B_mps2;
  seen.rotor_speed_radps = state_.rotor_speed_radps;
  seen.voltage_V = voltage_V_;
  return seen;
}

Wrench Plant::disturbance() {
  const Flow flow = evaluate(state_.rotor_speed_radps);
  return forces_.disturbance(flow, rotors_, effect_state_);
}

std::vector<double> Plant::snapshot() const {
  std::vector<double> out{static_cast<double>(steps_), static_cast<double>(observations_), start_time_s_, voltage_V_,
                          finite_ ? 1.0 : 0.0};
  const Packed state = pack(state_);
  out.insert(out.end(), state.begin(), state.end());
  out.insert(out.end(), rotor_acceleration_radps2_.begin(), rotor_acceleration_radps2_.end());
  out.insert(out.end(), effect_state_.begin(), effect_state_.end());
  memory_->body.save(out);
  memory_->commands.save(out);
  memory_->poses.save(out);
  return out;
}

void Plant::restore(const std::vector<double>& snapshot) {
  const double* in = snapshot.data();
  steps_ = static_cast<std::int64_t>(in[0]);
  observations_ = static_cast<std::int64_t>(in[1]);
  start_time_s_ = in[2];
  voltage_V_ = in[3];
  finite_ = in[4] != 0.0;
  in += 5;
  Packed state;
  std::copy_n(in, packed_size, state.begin());
  state_ = unpack(state);
  in += packed_size;
  std::copy_n(in, max_rotors, rotor_acceleration_radps2_.begin());
  in += max_rotors;
  std::copy_n(in, effect_state_.size(), effect_state_.begin());
  in += effect_state_.size();
  in = memory_->body.load(in);
  in = memory_->commands.load(in);
  memory_->poses.load(in);
  memory_->now_s = state_.time_s;
}

}  // namespace gustlab
