#include "plant/force_model.hpp"

#include <algorithm>
#include <tuple>

#include "config/toml.hpp"
#include "util/three.hpp"

namespace gustlab {

namespace {

// wrench effects that act on the rotors' flow (steady_wind) do so in the rotor pass
bool acts_on_flow(Place place) { return place == Place::rotor || place == Place::wrench; }

// the part of the plant's effect state that belongs to one effect
template <class Number, class Entry>
std::span<Number> slice(std::span<Number> state, const Entry& entry) {
  return state.subspan(static_cast<std::size_t>(entry.offset), static_cast<std::size_t>(entry.size));
}

}  // namespace

ForceModel::ForceModel(const VehicleModel& nominal, std::vector<NamedEffect> effects)
    : nominal_(nominal), vehicle_(nominal), effects_(std::move(effects)) {
  std::stable_sort(effects_.begin(), effects_.end(), [](const NamedEffect& a, const NamedEffect& b) {
    return std::tie(a.row->place, a.row->order, a.row->name) < std::tie(b.row->place, b.row->order, b.row->name);
  });
}

void ForceModel::prepare(double step_s, std::uint64_t seed, std::uint32_t replicate) {
  step_s_ = step_s;
  vehicle_ = nominal_;
  for (const NamedEffect& named : effects_) named.effect->on_body(vehicle_);
  inverse_inertia_ = vehicle_.inertia_B_kgm2.inverse();
  for (std::size_t i = 0; i < static_cast<std::size_t>(vehicle_.rotor_count); ++i)
    hub_B_m_[i] = vehicle_.rotors[i].position_B_m - vehicle_.center_of_mass_B_m;

  actuation_.clear(), rotor_.clear(), measurement_.clear(), wrench_.clear(), stateful_.clear();
  state_size_ = 0;
  for (const auto& [row, effect, spec] : effects_) {
    config::at_place(spec, [&, &effect = effect, row = row] {
      effect->prepare(vehicle_, step_s, RandomStream(seed, replicate, row->name));
    });
    const Stateful entry{effect.get(), state_size_, effect->state_size(), row->external};
    state_size_ += entry.size;
    if (entry.size > 0) stateful_.push_back(entry);
    if (acts_on_flow(row->place)) rotor_.push_back(effect.get());
    if (row->place == Place::wrench) wrench_.push_back(entry);
    if (row->place == Place::measurement) measurement_.push_back(effect.get());
  }
  // the command's way: delay, saturation, sag, lag (orders of both places are one scale)
  std::vector<const NamedEffect*> chain;
  for (const NamedEffect& named : effects_)
    if (named.row->place == Place::actuation || named.row->place == Place::rotor) chain.push_back(&named);
  std::stable_sort(chain.begin(), chain.end(),
                   [](const NamedEffect* a, const NamedEffect* b) { return a->row->order < b->row->order; });
  for (const NamedEffect* named : chain) actuation_.push_back(named->effect.get());
  // effects of the flow come first: wrench places that change the wind, then the rotors in their order
  std::stable_partition(rotor_.begin(), rotor_.end(), [this](const Effect* effect) {
    return std::any_of(wrench_.begin(), wrench_.end(), [effect](const Stateful& s) { return s.effect == effect; });
  });
}

double ForceModel::lookback_s() const {
  double longest = 0.0;
  for (const NamedEffect& named : effects_) longest = std::max(longest, named.effect->lookback_s());
  return longest;
}

void ForceModel::reset_state(std::span<double> state) const {
  for (const Stateful& entry : stateful_) entry.effect->reset_state(slice(state, entry));
}

void ForceModel::actuate(Actuation& actuation) const {
  actuation.count = vehicle_.rotor_count;
  actuation.speed_is_measured = speed_is_measured_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(actuation.count); ++i)
    actuation.command_radps[i] = std::clamp(actuation.command_radps[i], 0.0, vehicle_.max_speed_radps);
  actuation.end_speed_radps = actuation.mean_speed_radps = actuation.command_radps;
  for (const Effect* effect : actuation_) effect->on_actuation(actuation);
}

Flow ForceModel::flow(const VehicleState& state, double voltage_V) const {
  Flow flow;
  flow.time_s = state.time_s;
  flow.position_W_m = state.position_W_m;
  const Matrix3& R_WB = flow.R_WB;
  rotation_of(state.attitude_WB, flow.R_WB);
  flow.body_rate_B_radps = state.body_rate_B_radps;
  const Three velocity_W_mps =
      state.velocity_W_mps + rotated(R_WB, cross(state.body_rate_B_radps, vehicle_.center_of_mass_B_m));
  flow.velocity_W_mps = velocity_W_mps;
  flow.air_velocity_B_mps = rotated_back(R_WB, velocity_W_mps);
  flow.voltage_V = voltage_V;
  flow.speed_is_measured = speed_is_measured_;
  flow.vehicle = &vehicle_;
  return flow;
}

void ForceModel::rotors(const RotorArray& speed_radps, const RotorArray& acceleration_radps2, Flow& flow,
                        RotorSet& set) const {
  set.count = vehicle_.rotor_count;
  set.speed_radps = speed_radps;
  set.acceleration_radps2 = acceleration_radps2;
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Rotor& rotor = vehicle_.rotors[i];
    set.hub_B_m[i] = hub_B_m_[i];
    set.axis_B[i] = rotor.axis_B;
    set.direction[i] = rotor.direction;
    set.thrust_N[i] = rotor.thrust_coefficient_Ns2 * speed_radps[i] * speed_radps[i];
    set.reaction_Nm[i] = rotor.torque_ratio_m * set.thrust_N[i];
  }
  for (const Effect* effect : rotor_) effect->on_rotor(flow, set);
}

Wrench ForceModel::wrench(const Flow& flow, const RotorSet& set, std::span<const double> state) const {
  Three force_B_N(0.0, 0.0, 0.0), torque_B_Nm(0.0, 0.0, 0.0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(set.count); ++i) {
    const Three axis = set.axis_B[i], thrust = set.thrust_N[i] * axis;
    force_B_N = force_B_N + thrust;
    torque_B_Nm = torque_B_Nm + (cross(set.hub_B_m[i], thrust) - set.direction[i] * set.reaction_Nm[i] * axis);
  }
  Wrench total{force_B_N, torque_B_Nm};
  for (const Stateful& entry : wrench_) entry.effect->wrench(flow, set, slice(state, entry), total);
  return total;
}

Wrench ForceModel::disturbance(const Flow& flow, const RotorSet& set, std::span<const double> state) const {
  Wrench total;
  for (const Stateful& entry : wrench_)
    if (entry.external) entry.effect->wrench(flow, set, slice(state, entry), total);
  return total;
}

Acceleration ForceModel::acceleration(const Flow& flow, const Wrench& wrench) const {
  const Three force_W_N = rotated(flow.R_WB, wrench.force_B_N), rate = flow.body_rate_B_radps;
  const double mass = vehicle_.mass_kg;
  const Three momentum = rotated(vehicle_.inertia_B_kgm2, rate);
  return {Vector3(force_W_N.x / mass, force_W_N.y / mass, force_W_N.z / mass - vehicle_.gravity_mps2),
          rotated(inverse_inertia_, wrench.torque_B_Nm - cross(rate, momentum))};
}

Vector3 ForceModel::specific_force_at_origin(const Flow& flow, const Wrench& wrench,
                                             const Vector3& angular_acceleration_B_radps2) const {
  const Three arm = vehicle_.center_of_mass_B_m, rate = flow.body_rate_B_radps, force = wrench.force_B_N;
  const double mass = vehicle_.mass_kg;
  return Three(force.x / mass, force.y / mass, force.z / mass) - cross(angular_acceleration_B_radps2, arm) -
         cross(rate, cross(rate, arm));
}

void ForceModel::advance(const Flow& flow, const RotorSet& set, const Wrench& wrench, std::span<double> state) const {
  for (const Stateful& entry : stateful_) entry.effect->advance(flow, set, wrench, step_s_, slice(state, entry));
}

void ForceModel::measure(const MeasurementContext& context, Measured& measured) const {
  for (const Effect* effect : measurement_) effect->on_measurement(context, measured);
}

}  // namespace gustlab
