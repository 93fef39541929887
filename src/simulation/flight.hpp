// One flight: vehicle, trajectory, controller and gust, from start to outcome.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "gustlab/controller.hpp"
#include "gustlab/trajectory.hpp"
#include "metrics/effort.hpp"
#include "metrics/tracking_error.hpp"
#include "plant/plant.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

enum class Outcome { completed, crashed, left_envelope, diverged, controller_nonfinite };
std::string_view to_string(Outcome outcome);
std::optional<Outcome> find_outcome(std::string_view text);

// What a run came to.
struct RunRecord {
  RunSpec spec;
  Outcome outcome = Outcome::completed;
  double duration_s = 0.0;  // flown
  TrackingFigures error;
  EffortFigures effort;
};

class FlightRecorder;

// A pose as it was sent over the offboard link.
struct LinkMessage {
  std::int64_t arrival_tick = 0;
  double time_s = 0.0;
  Vector3 position_W_m = Vector3::Zero(), velocity_W_mps = Vector3::Zero();
};

// What a flight in hand does at an interrupt: it is finished, or ends at its next tick by throwing Interrupted.
enum class AtInterrupt { finish, end };

// Everything that one run owns; no two runs share anything that changes.
struct Flight {
  // Throws ConfigError when the parts do not fit together, ParameterError when it is for a key of the experiment.
  Flight(const Experiment& experiment, const RunSpec& spec);

  // Where the vehicle should be: the trajectory, with the hovers before and after it.
  Reference reference_at(double time_s) const;

  FlightOptions options;     // with the duration resolved, hovers included
  double manoeuvre_s = 0.0;  // what of it is the trajectory
  std::unique_ptr<Trajectory> trajectory;
  std::unique_ptr<Controller> controller, first_controller;  // the first flies up to the hand-over, if there is one
  ControllerSetup setup;                                     // of both
  Plant plant;
  std::int64_t ticks = 0;               // updates of the controller
  std::int64_t hand_over_tick = 0;      // the first of its own
  std::int64_t steps_per_tick = 1;      // of the plant
  std::int64_t ticks_per_offboard = 1;  // between two messages of the offboard link
  std::int64_t ticks_per_row = 1;       // between two rows of the log
  double tick_s = 0.0;                  // between two updates of the controller
  std::size_t rotors = 0;
  AtInterrupt at_interrupt = AtInterrupt::finish;
  RandomStream link_stream;                // which messages of the link are lost, and how late the others are
  std::vector<LinkMessage> link_messages;  // ring of those that are under way
};

struct FlightEnd {
  Outcome outcome;
  double time_s;
};

// Flies a flight that was just made. Contract: time is step × dt, never accumulated; errors and effort (where it is asked for) sample
// every tick up to the one that ends the flight; no heap allocation, with or without a recorder, but at a hand-over.
FlightEnd fly(Flight& flight, TrackingError& error, FlightRecorder* recorder, Effort* effort = nullptr);

// A planned run from start to figures.
RunRecord run(const Experiment& experiment, const RunSpec& spec, AtInterrupt at_interrupt = AtInterrupt::finish);

}  // namespace gustlab
