// The vehicle's forces, without an integrator: nominal rotors plus a list of effects.
//
// The plant integrates what this computes with MuJoCo; the diagnosis linearises the very same object along a flight.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gustlab/effect.hpp"

namespace gustlab {

// Linear and angular acceleration of the centre of mass.
struct Acceleration {
  Vector3 linear_W_mps2 = Vector3::Zero();
  Vector3 angular_B_radps2 = Vector3::Zero();
};

class ForceModel {
 public:
  // The effects are applied in the registry's order of application, whatever order they are given in.
  ForceModel(const VehicleModel& nominal, std::vector<NamedEffect> effects);
  ForceModel(ForceModel&&) = default;
  ForceModel& operator=(ForceModel&&) = default;

  // Applies body effects and prepares all others; call again after parameters were changed.
  void prepare(double step_s, std::uint64_t seed, std::uint32_t replicate);

  const VehicleModel& vehicle() const { return vehicle_; }  // with body effects
  std::span<NamedEffect> effects() { return effects_; }
  std::span<const NamedEffect> effects() const { return effects_; }
  double lookback_s() const;
  // The log measured rotor speed: it drives the body, and actuation effects explain command → speed alone.
  void set_speed_is_measured(bool measured) { speed_is_measured_ = measured; }

  int state_size() const { return state_size_; }
  void reset_state(std::span<double> state) const;

  // command → rotor speeds over one step; fills end and mean speeds.
  void actuate(Actuation& actuation) const;
  // Flow at a state of the body origin: velocity of the centre of mass, still air.
  Flow flow(const VehicleState& state, double voltage_V) const;
  // Thrust and reaction of every rotor, with rotor effects; steady_wind changes the flow.
  void rotors(const RotorArray& speed_radps, const RotorArray& acceleration_radps2, Flow& flow, RotorSet& set) const;
  // Force and torque about the centre of mass, weight excluded.
  Wrench wrench(const Flow& flow, const RotorSet& set, std::span<const double> state) const;
  // The part of it that comes from outside (gust, constant force).
  Wrench disturbance(const Flow& flow, const RotorSet& set, std::span<const double> state) const;
  // Newton and Euler for the centre of mass.
  Acceleration acceleration(const Flow& flow, const Wrench& wrench) const;
  // What an accelerometer at the body's origin reads.
  Vector3 specific_force_at_origin(const Flow& flow, const Wrench& wrench,
                                   const Vector3& angular_acceleration_B_radps2) const;
  // Advances the memories of the effects over one step that began with this wrench.
  void advance(const Flow& flow, const RotorSet& set, const Wrench& wrench, std::span<double> state) const;
  void measure(const MeasurementContext& context, Measured& measured) const;

 private:
  VehicleModel nominal_;
  VehicleModel vehicle_;
  Matrix3 inverse_inertia_ = Matrix3::Identity();
  std::array<Vector3, max_rotors> hub_B_m_;  // from the centre of mass
  std::vector<NamedEffect> effects_;
  // effects by hook, so that the loop calls only those that act there
  std::vector<const Effect*> actuation_, rotor_, measurement_;
  struct Stateful {
    const Effect* effect;
    int offset, size;
    bool external;
  };
  std::vector<Stateful> wrench_, stateful_;
  int state_size_ = 0;
  double step_s_ = 0.0;
  bool speed_is_measured_ = false;
};

}  // namespace gustlab
