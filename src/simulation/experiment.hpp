// An experiment as a value: what one TOML file says, defaults filled in, and the list of runs that it asks for.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "config/toml.hpp"
#include "gustlab/parameters.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// A trajectory or a controller under the name that results carry.
struct Choice {
  std::string name;
  EffectSpec spec;  // type in its registry, and parameters
};

// A value in words: where a variant stands on an axis, how much of a trajectory was flown.
struct NamedValue {
  std::string name, value;
  bool operator==(const NamedValue&) const = default;
};

// What a flight is besides vehicle, trajectory and controller.
struct FlightOptions final : Parameterized {
  double duration_s = 0.0;          // of the manoeuvre; 0: as long as the trajectory says
  double laps = 0.0;                // of the trajectory, in place of a duration; 0: the duration decides
  double hover_before_s = 0.0;      // the reference stands where the vehicle starts,
  double hover_after_s = 0.0;       // and where the manoeuvre ends
  double hand_over_s = 0.0;         // until then the vehicle's own position loop flies
  double step_s = 0.002;            // of the plant; divides the controller's period
  double settle_s = 0.0;            // samples before it do not count
  double offboard_rate_hz = 0.0;    // position, velocity and reference reach the controller at this rate; 0: every tick
  double offboard_delay_s = 0.0;    // age at which position and velocity reach it
  double offboard_jitter_s = 0.0;   // what a message may be later than that, drawn for each
  double offboard_dropout = 0.0;    // share of the messages that are lost, set points with them
  std::string set_points = "full";  // what of the reference reaches the controller: full, or its position and heading
  // the envelope, far beyond any flight that is worth a figure
  double max_error_m = 100.0;  // distance from the reference
  double max_speed_mps = 50.0;
  void visit(ParameterVisitor& visitor) override;
};

// What a flight log of the experiment holds.
struct LogOptions final : Parameterized {
  double log_rate_hz = 0.0;            // 0: a row every control tick
  std::string log_source = "sensors";  // sensors: what was measured; truth: the simulator's state
  void visit(ParameterVisitor& visitor) override;
};

struct Experiment {
  std::string name;
  std::string vehicle_name;         // as written, for the sidecar of a flight log
  VehicleModel vehicle;             // nominal, with the experiment's environment: what a controller knows
  std::vector<EffectSpec> effects;  // all that act: the vehicle's own, the included, the experiment's
  std::vector<Choice> trajectories, controllers;
  std::int64_t replicates = 1;
  std::int64_t first_replicate = 1;
  std::int64_t seed = 1;
  FlightOptions flight;
  LogOptions log;
  std::string variant;  // name of its [[variant]] or point of its grid; empty: it is the experiment as it stands
  std::vector<NamedValue> axes;        // "variant" where it is a [[variant]], then the [[axis]] tables in their order
  std::vector<NamedValue> axis_units;  // of the [[axis]] tables that are crossed, where they have one
  NamedValue alone;                    // the one axis that it moves along, where that is `alone`
  std::size_t variant_place = 0;       // among the variants of the file, from 0
  std::size_t variants = 0;            // that are flown with it, itself too
  bool held_out = false;               // a variant that training only tests on
  bool speed_is_logged = false;        // concealed trials: see Plant::Options
};

// One run: indices into its experiment, and 128 bits that stand for everything that can change its result.
struct RunSpec {
  std::size_t index = 0;  // in plan order
  std::size_t trajectory = 0;
  std::size_t controller = 0;
  std::uint32_t replicate = 1;
  std::array<std::uint64_t, 2> key{};
};
std::string to_hex(const std::array<std::uint64_t, 2>& key);

// Throws ConfigError with file:line:col, also for what would only show in flight: a step that does not divide the
// controller's period, a trajectory that contradicts itself. `overrides` are `key=value` pairs with dotted keys.
Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides = {});
// The variants of a file: one experiment for each [[variant]] and each point of the grid of its [[axis]] tables, named
// NAME.VARIANT, in which the variant's settings hold (and `overrides`, which may not be of the same keys); without any, the
// experiment itself. `only`: the names of those to read, all when empty. Throws as above.
std::vector<Experiment> read_variants(const std::string& path, const std::vector<std::string>& overrides = {},
                                      const std::vector<std::string>& only = {});
// The same from a table that was read already, but for its format; `path` is what relative paths resolve against.
Experiment make_experiment(config::Table& document, const std::string& path);
// Whether `setting` could be set above `overrides`, for a file that asks for it at `where`. Throws ConfigError there.
void check_override(const std::string& path, std::vector<std::string> overrides, const std::string& setting,
                    const std::string& where);
// A path as given, or a name under experiments/. Throws ConfigError when there is neither.
std::string find_experiment(const std::string& name_or_path);
// The keys of an experiment outside its tables, for `gustlab defaults experiment`.
std::unique_ptr<Parameterized> make_experiment_keys();

// Every run, by trajectory, then controller, then replicate.
std::vector<RunSpec> plan(const Experiment& experiment);
// How much of each trajectory a flight flies, for captions: circle: "17.4 s, 2.2 m, 0.32 laps".
std::vector<NamedValue> arcs_of(const Experiment& experiment);
// Everything that can change a result of the experiment; equal texts and equal programs give equal bytes.
std::string resolved_text(const Experiment& experiment);

}  // namespace gustlab
