#include "diagnosis/rollout/rollout.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/make_effects.hpp"
#include "util/rotations.hpp"

namespace gustlab::diagnosis {

namespace {

std::vector<NamedEffect> predictable(const std::vector<EffectSpec>& specs) {
  std::vector<NamedEffect> effects = make_effects(specs);
  std::erase_if(effects, [](const NamedEffect& e) { return !e.row->is_predictable(); });
  return effects;
}

Measured measured(const Observation& seen) {
  return {seen.position_W_m, seen.velocity_W_mps, seen.attitude_WB, seen.body_rate_B_radps, Vector3::Zero()};
}

Measured mixed(const Measured& a, const Measured& b, double part) {
  Measured m;
  m.position_W_m = a.position_W_m + part * (b.position_W_m - a.position_W_m);
  m.velocity_W_mps = a.velocity_W_mps + part * (b.velocity_W_mps - a.velocity_W_mps);
  m.attitude_WB = a.attitude_WB.slerp(part, b.attitude_WB);
  m.body_rate_B_radps = a.body_rate_B_radps + part * (b.body_rate_B_radps - a.body_rate_B_radps);
  return m;
}

// a past in which nothing moved
struct Still final : MeasurementContext::Past {
  VehicleState state;
  VehicleState at(double) const override { return state; }
};

}  // namespace

Recording::Recording(const FlightLog& flight_log, const VehicleModel& nominal, const ReplayOptions& options)
    : log(with_shared_rows(flight_log)), motion(log) {
  FlightData data = prepare_flight(flight_log, nominal, {});
  vehicle = data.vehicle;
  vehicle.shapes.clear();
  speed_is_measured = !data.measured_speed.empty();
  inputs = !data.jumping_speed.empty() ? std::move(data.jumping_speed)
           : speed_is_measured         ? std::move(data.measured_speed)
                                       : std::move(data.commands);
  inputs.delay(options.command_delay_s);
  collective_only = data.collective_only && !speed_is_measured;
  step_s = motion.sample_s() / std::max(1.0, std::ceil(motion.sample_s() / options.max_step_s - 1e-9));
  if (const auto* volts = log.find("vbat")) {
    double last = nominal.nominal_voltage_V;
    for (const double v : *volts) voltage_V.push_back(std::isfinite(v) ? last = v : last);
  }
}

Rollout::Rollout(const Recording& recording, const std::vector<EffectSpec>& effects)
    : recording_(recording),
      plant_(recording.vehicle, predictable(effects), {.step_s = recording.step_s, .seed = 1, .replicate = 1}) {
  plant_.set_speed_is_measured(recording.speed_is_measured);
  for (const NamedEffect& named : plant_.forces().effects())
    if (named.row->place == Place::measurement) pose_delay_s_ = std::max(pose_delay_s_, named.effect->lookback_s());
}

RotorCommand Rollout::command(double from_s) const {
  const double at_s = recording_.log.time_s.front() + from_s;
  return {recording_.inputs.mean(at_s, at_s + recording_.step_s)};
}

std::vector<RotorArray> Rollout::rotor_speeds() {
  const double step_s = recording_.step_s;
  std::vector<RotorArray> speeds;
  VehicleState state;
  state.rotor_speed_radps = command(0.0).speed_radps;
  plant_.reset(state);
  const std::int64_t most = std::lround(longest_walk_s / step_s);
  std::int64_t step = 0;
  for (std::size_t row = 0; row < recording_.motion.rows(); ++row) {
    const std::int64_t wanted = std::lround(recording_.motion.time_s(row) / step_s);
    step = std::max(step, wanted - most);
    if (!recording_.voltage_V.empty()) plant_.set_voltage(recording_.voltage_V[row]);
    for (; step < wanted; ++step) plant_.advance_actuation(command(static_cast<double>(step) * step_s));
    speeds.push_back(plant_.state().rotor_speed_radps);
  }
  return speeds;
}

VehicleState Rollout::start(std::size_t row) const {
  const RecordedMotion& motion = recording_.motion;
  Measured wanted;
  wanted.position_W_m = motion.position_W_m(row);
  wanted.velocity_W_mps = motion.velocity_W_mps(row);
  wanted.attitude_WB = motion.attitude_WB(row);
  // the pose is late, the body rate is not
  const double time_s = motion.time_s(row) - pose_delay_s_;
  wanted.body_rate_B_radps = pose_delay_s_ > 0.0 ? motion.body_rate_at(time_s) : motion.body_rate_B_radps(row);

  // sensor effects are small and smooth: what they add is taken out until the sensors say what was recorded
  VehicleState state{time_s, wanted.position_W_m, wanted.velocity_W_mps, wanted.attitude_WB, wanted.body_rate_B_radps,
                     {}};
  for (int repeat = 0; repeat < 4; ++repeat) {
    Still past;
    past.state = state;
    MeasurementContext context;
    context.time_s = time_s;
    context.past = &past;
    Measured said{state.position_W_m, state.velocity_W_mps, state.attitude_WB, state.body_rate_B_radps,
                  Vector3::Zero()};
    plant_.forces().measure(context, said);
    state.position_W_m += wanted.position_W_m - said.position_W_m;
    state.velocity_W_mps += wanted.velocity_W_mps - said.velocity_W_mps;
    state.attitude_WB = turned(state.attitude_WB, turn_between(said.attitude_WB, wanted.attitude_WB));
    state.body_rate_B_radps += wanted.body_rate_B_radps - said.body_rate_B_radps;
  }
  return state;
}

void Rollout::begin(const VehicleState& start, const std::vector<RotorArray>& rotor_speeds) {
  const RecordedMotion& motion = recording_.motion;
  const double step_s = recording_.step_s;
  const auto last_row = [&](double time_s) {
    const std::size_t row = motion.nearest(time_s);
    return row > 0 && motion.time_s(row) > time_s + 0.5 * step_s ? row - 1 : row;
  };
  // delay lines fill from a lookback before; the rotors' own speed is known from running the whole recording
  const std::size_t first = last_row(start.time_s - plant_.forces().lookback_s()), last = last_row(start.time_s);
  const auto steps_from = [&](std::size_t row) { return std::lround((start.time_s - motion.time_s(row)) / step_s); };
  VehicleState state = start;
  if (!recording_.voltage_V.empty()) plant_.set_voltage(recording_.voltage_V[last]);
  state.rotor_speed_radps = rotor_speeds[first];
  plant_.reset(state);
  for (long step = std::min(steps_from(first), std::lround(longest_walk_s / step_s)); step > 0; --step) {
    if (step == steps_from(last)) restart_rotors(rotor_speeds[last]);
    plant_.advance_actuation(command(start.time_s - static_cast<double>(step) * step_s));
  }
  if (steps_from(last) == 0) restart_rotors(rotor_speeds[last]);
  if (recording_.speed_is_measured) restart_rotors(command(start.time_s).speed_radps);
  begin_s_ = start.time_s;
  beside_recorded_ = motion.attitude_at(start.time_s + pose_delay_s_).conjugate() * start.attitude_WB;
  steps_ = 0;
  before_ = now_ = measured(plant_.observe(false));
}

void Rollout::restart_rotors(const RotorArray& speed_radps) {
  VehicleState state = plant_.state();
  state.rotor_speed_radps = speed_radps;
  plant_.set_state(state);
}

bool Rollout::advance() {
  const double time_s = begin_s_ + static_cast<double>(steps_) * recording_.step_s;
  if (!recording_.voltage_V.empty()) plant_.set_voltage(recording_.voltage_V[recording_.motion.nearest(time_s)]);
  if (!plant_.step(command(time_s))) return false;
  ++steps_;
  if (!recording_.collective_only) return true;
  VehicleState state = plant_.state();
  state.attitude_WB = recording_.motion.attitude_at(state.time_s + pose_delay_s_) * beside_recorded_;
  state.body_rate_B_radps = recording_.motion.body_rate_at(state.time_s);
  plant_.set_state(state);
  return true;
}

bool Rollout::run_to(double time_s, Measured& seen) {
  const double steps = (time_s - begin_s_) / recording_.step_s;
  constexpr double rounding = 1e-6;
  while (static_cast<double>(steps_) < steps - rounding) {
    if (static_cast<double>(steps_ + 1) >= steps - rounding) before_ = measured(plant_.observe(false));
    if (!advance()) return false;
  }
  now_ = measured(plant_.observe(false));
  const double over = static_cast<double>(steps_) - steps;
  seen = over > rounding ? mixed(now_, before_, over) : now_;
  return true;
}

}  // namespace gustlab::diagnosis
