// The plant: the vehicle's forces integrated by MuJoCo. The only code that knows MuJoCo, and where its traps end.
//
// MuJoCo steps a free body at the centre of mass, without geometry or actuators while airborne (the wrench goes to
// qfrc_applied, for a free joint a force in W and a torque in body axes), and a twin with the vehicle's collision shapes and
// a floor when it comes near the ground. A NaN never resets the state: step() says so and stops.
#pragma once

#include <memory>
#include <vector>

#include "plant/force_model.hpp"

namespace gustlab {

class Plant {
 public:
  struct Options {
    double step_s = 0.002;
    std::uint64_t seed = 1;
    std::uint32_t replicate = 1;
    bool speed_is_logged =
        false;  // rotor speeds in the log drive whoever reads it: a sagging battery lowers speeds, not thrust
  };

  // Throws ConfigError when the vehicle's mass or inertia is not positive.
  Plant(const VehicleModel& nominal, std::vector<NamedEffect> effects, const Options& options);
  ~Plant();

  // Places the vehicle and forgets the past: delay lines hold this state, effects start afresh.
  void reset(const VehicleState& state);
  // Moves body and rotors and keeps every other memory.
  void set_state(const VehicleState& state);
  // Advances one step; false when the state is no longer finite, and then for ever.
  [[nodiscard]] bool step(const RotorCommand& command);
  // Advances delay lines and rotors alone, the body stands still.
  void advance_actuation(const RotorCommand& command);

  const VehicleState& state() const { return state_; }
  std::int64_t steps() const { return steps_; }
  double step_s() const { return options_.step_s; }
  bool touches_ground() const;
  // The commands are measured rotor speeds: they drive the body as they are.
  void set_speed_is_measured(bool measured);
  void set_voltage(double voltage_V) { voltage_V_ = voltage_V; }
  double voltage_V() const { return voltage_V_; }

  // What the sensors say now; the accelerometer costs one more evaluation of the forces.
  Observation observe(bool with_accelerometer);
  // Disturbance from outside at the present state.
  Wrench disturbance();

  const ForceModel& forces() const { return forces_; }
  ForceModel& forces() { return forces_; }

  // Everything that the future depends on, as a flat list of numbers.
  std::vector<double> snapshot() const;
  void restore(const std::vector<double>& snapshot);

 private:
  struct Memory;  // the body in MuJoCo and what delays remember

  void actuate(const RotorCommand& command);
  Flow evaluate(const RotorArray& speed_radps);  // fills rotors_

  Options options_;
  ForceModel forces_;
  std::unique_ptr<Memory> memory_;
  std::vector<double> effect_state_;
  VehicleState state_;
  Actuation actuation_;
  RotorSet rotors_;
  RotorArray rotor_acceleration_radps2_{};
  double voltage_V_ = 0.0;
  std::int64_t steps_ = 0;
  std::int64_t observations_ = 0;
  double start_time_s_ = 0.0;
  bool finite_ = true;
  bool speed_is_measured_ = false;
  bool remembers_ = false;  // some effect looks back
};

}  // namespace gustlab
