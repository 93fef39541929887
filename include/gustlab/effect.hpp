// Everything that bends the nominal rigid body is an Effect: a gust, rotor drag, a motor's lag, a late log.
//
// There are exactly five places where physics can enter: body, actuation, rotor, wrench, measurement. An effect fills in
// the hooks that it needs; every hook does nothing by default. The simulator applies it and the diagnosis fits the very
// same object: its author writes the forward model once, and no derivative by hand.
//
// Contract: at zero strength no hook changes a bit. Hooks are const: an effect's memory is the slice of the plant's state
// that it is handed, so that a snapshot of the plant carries everything.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gustlab/parameters.hpp"
#include "gustlab/random.hpp"
#include "gustlab/types.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

enum class Place { body, actuation, rotor, wrench, measurement };
std::string_view to_string(Place place);

// The command's way to the rotors during one step. `command` is the mean over the step of what is asked for.
struct Actuation {
  int count = 0;
  double time_s = 0.0;  // start of the step
  double step_s = 0.0;
  double voltage_V = 0.0;          // 0: not known
  bool speed_is_measured = false;  // rotor speed in the log drives the body; only command → speed is modelled
  RotorArray command_radps{};      // in, and changed by delay, saturation, sag
  RotorArray start_speed_radps{};  // Ω at the start of the step
  RotorArray end_speed_radps{};    // Ω at its end; the command when there is no lag
  RotorArray mean_speed_radps{};   // what the air feels during the step; likewise
  // changes what is asked of rotor i; a lag, which comes later, starts from it
  void set_command(std::size_t i, double speed_radps) {
    command_radps[i] = end_speed_radps[i] = mean_speed_radps[i] = speed_radps;
  }
  // mean command over the interval [time − age, time − age + step] before this one; ages up to the largest lookback
  struct Past {
    virtual ~Past() = default;
    virtual void command(double age_s, RotorArray& speed_radps) const = 0;
  };
  const Past* past = nullptr;
};

// The flight condition at one instant. Velocities are of the centre of mass.
struct Flow {
  double time_s = 0.0;
  Vector3 position_W_m = Vector3::Zero();    // of the body's origin
  Vector3 velocity_W_mps = Vector3::Zero();  // of the centre of mass
  Matrix3 R_WB = Matrix3::Identity();
  Vector3 body_rate_B_radps = Vector3::Zero();
  Vector3 air_velocity_B_mps = Vector3::Zero();  // v_r = Rᵀ(v − wind); steady_wind changes it
  double voltage_V = 0.0;
  bool speed_is_measured = false;
  const VehicleModel* vehicle = nullptr;  // with body effects applied
};

// The rotors at one instant. Hubs are from the centre of mass.
struct RotorSet {
  int count = 0;
  std::array<Vector3, max_rotors> hub_B_m;
  std::array<Vector3, max_rotors> axis_B;
  RotorArray direction{};            // s_i
  RotorArray speed_radps{};          // Ω_i
  RotorArray acceleration_radps2{};  // dΩ_i/dt
  RotorArray thrust_N{};             // f_i along axis
  RotorArray reaction_Nm{};          // magnitude; torque on the body is −s_i reaction axis

  // Velocity of hub i through the air: v_r + ω × r_i.
  Vector3 hub_velocity_B_mps(const Flow& flow, int i) const {
    return flow.air_velocity_B_mps + flow.body_rate_B_radps.cross(hub_B_m[static_cast<std::size_t>(i)]);
  }
};

// What the sensors say at one instant, and the past that a late sensor needs.
struct Measured {
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  Quaternion attitude_WB = Quaternion::Identity();
  Vector3 body_rate_B_radps = Vector3::Zero();
  Vector3 specific_force_B_mps2 = Vector3::Zero();
};
struct MeasurementContext {
  double time_s = 0.0;
  Vector3 angular_acceleration_B_radps2 = Vector3::Zero();
  std::int64_t tick = 0;  // counts observations, for random streams
  struct Past {
    virtual ~Past() = default;
    virtual VehicleState at(double time_s) const = 0;  // interpolated truth; never later than now
  };
  const Past* past = nullptr;
};

class Effect : public Parameterized {
 public:
  // Called once, after every body effect: the vehicle that flies, the plant's step, the run's random stream. Throws
  // ParameterError when the parameters do not fit them or each other.
  virtual void prepare(const VehicleModel&, double /*step_s*/, const RandomStream&) {}
  // The longest memory that actuation or measurement asks of the past, s.
  virtual double lookback_s() const { return 0.0; }

  virtual int state_size() const { return 0; }
  virtual void reset_state(std::span<double>) const {}
  // Advances the memory over one step from its start; the wrench is the whole of that step, weight excluded.
  virtual void advance(const Flow&, const RotorSet&, const Wrench& /*total*/, double /*step_s*/,
                       std::span<double>) const {}

  virtual void on_body(VehicleModel&) const {}
  virtual void on_actuation(Actuation&) const {}
  virtual void on_rotor(Flow&, RotorSet&) const {}
  // Adds to the wrench; what it holds already are the rotors and all effects of a lower order.
  virtual void wrench(const Flow&, const RotorSet&, std::span<const double>, Wrench&) const {}
  virtual void on_measurement(const MeasurementContext&, Measured&) const {}
};

// What a log must tell, or its sidecar or the vehicle file know, before an effect can be told from it.
enum class Need : unsigned {
  nothing = 0,
  attitude = 1,
  motion = 2,
  torque = 4,
  accelerometer = 8,
  ground = 16,
  ceiling = 32,
  wall = 64,
  rotor_radius = 128,
  rotor_speed = 256,
  torque_ratio = 512,
  gyro = 1024
};
constexpr Need operator|(Need a, Need b) {
  return static_cast<Need>(static_cast<unsigned>(a) | static_cast<unsigned>(b));
}
constexpr Need operator&(Need a, Need b) {
  return static_cast<Need>(static_cast<unsigned>(a) & static_cast<unsigned>(b));
}

// Where the column of an effect's strength comes from: the regression of the diagnosis has one per parameter.
enum class ColumnFrom {
  model,        // the forward model, perturbed
  swing,        // a history: the force of a load whose swing a scan found
  speed_limit,  // a history: what changes under a speed limit that a scan found
  nowhere       // known by its statistics only: sought in what is left, and left out of predictions
};
// How an effect has to do with the velocity of the air past the vehicle.
enum class Airflow {
  ignored,
  felt,
  drag,  // felt, and there in any motion
  wind   // moves the air: nothing without those that feel it
};
// How late an effect makes what goes through its place, in its first parameter.
enum class Latency { none, lag, delay };
// What of the recorded motion an effect corrects, parameter by parameter. A late pose is Latency::delay of a measurement.
enum class Corrects { nothing, attitude, heading, rate_scale };
// What mean commands of hover show of an effect.
enum class InHover { nothing, weight, center, rotor };
// No flight tells an effect from the last number of another one, except where one of `unless` is there as well.
struct ExactAlias {
  std::string_view effect = {};
  std::array<std::string_view, 2> unless = {};
};

// A row of the registry: what is said of an effect without making one. Order of rows is the catalogue's (DIAGNOSIS.md §5).
// The diagnosis asks for these traits and never for a name; tests/contract/effect_traits_test.cpp holds each of them.
struct EffectRow {
  std::string_view name;
  Place place;
  int order;                 // of application within its place
  bool per_flight = false;   // fitted per flight, otherwise per vehicle
  bool diagnosable = true;   // false: simulator only (measurement_noise, sindy_residual)
  bool external = false;     // a disturbance from outside, logged as fx…tz
  bool replay_only = false;  // true of the loop that was recorded and of no other
  bool describes = false;    // what the diagnosis writes for a remainder without a name
  bool commanded = false;    // seen only in how the vehicle answers its commands
  bool on_command = false;   // changes how fast a commanded rotor turns (on_actuation)
  bool built_in = false;     // of parts that stay as they are: no flight differs in it from another of the same vehicle
  bool per_rotor = false;    // one candidate for each rotor, by its integer parameter `rotor`
  ColumnFrom column = ColumnFrom::model;
  Airflow air = Airflow::ignored;
  Latency latency = Latency::none;
  Corrects corrects = Corrects::nothing;
  InHover in_hover = InHover::nothing;
  Need needs = Need::nothing;      // each of these
  Need needs_any = Need::nothing;  // one of these; `lacking` says why
  std::string_view lacking = {};
  std::string_view hidden_by_filter = {};  // why low-pass filtered logs do not tell it; empty: they do
  std::string_view stand_in = {};          // the effect that is named by logs which do not tell this one
  std::string_view never_beside = {};      // an exact alias of this one where the moments of inertia are free
  ExactAlias alias = {};
  std::string_view like_but_for_turning = {};  // what pushes the same for a command, and turns differently
  std::array<std::string_view, 2> like_unless_turning = {};  // what looks the same in flights that keep their heading
  std::string_view says;                                     // one plain sentence of what it does
  std::string_view shows_in;                                 // the flight that makes it visible
  std::string_view confused_with;                            // rivals, and what separates them
  std::string_view source;
  std::unique_ptr<Effect> (*make)();
  bool asks(Need need) const { return (needs & need) != Need::nothing; }
  bool is_history() const { return column == ColumnFrom::swing || column == ColumnFrom::speed_limit; }
  bool is_predictable() const { return column != ColumnFrom::nowhere; }
};

// An effect with the row that it came from.
struct NamedEffect {
  const EffectRow* row = nullptr;
  std::unique_ptr<Effect> effect;
  EffectSpec spec{};  // as it was written, when it was
};

std::span<const EffectRow> effect_registry();
const EffectRow* find_effect(std::string_view name);
// The first row, in the catalogue's order, of which this is true; throws when there is none.
const EffectRow& first_effect(bool (*is)(const EffectRow&));

}  // namespace gustlab
