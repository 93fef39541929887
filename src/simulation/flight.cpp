#include "simulation/flight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "simulation/make_effects.hpp"
#include "simulation/recorder.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

constexpr std::array<std::pair<Outcome, std::string_view>, 5> outcome_names{{
    {Outcome::completed, "completed"},
    {Outcome::crashed, "crashed"},
    {Outcome::left_envelope, "left_envelope"},
    {Outcome::diverged, "diverged"},
    {Outcome::controller_nonfinite, "controller_nonfinite"},
}};

// how often `part` fits into `whole`; throws, of a parameter, when it does not do so a whole number of times
std::int64_t divide(std::string_view of, double whole_s, double part_s, const std::string& whole_says,
                    const std::string& part_says, const std::string& advice = "") {
  const double times = std::round(whole_s / part_s);
  if (times < 1.0 || std::abs(times * part_s - whole_s) > 1e-9 * whole_s)
    throw ParameterError(of, fmt::format("{} {} s does not divide {} {} s{}", part_says, config::shortest(part_s),
                                         whole_says, config::shortest(whole_s), advice));
  return static_cast<std::int64_t>(times);
}

// updates of a controller between two rows of the log; throws where a row would fall between two of them, or where there is one row
std::int64_t ticks_of_row(double log_rate_hz, double loop_rate_hz, const std::string& controller, double flight_ticks) {
  const double ticks = loop_rate_hz / log_rate_hz, whole = std::round(ticks);
  const std::string says = fmt::format("\"log_rate_hz\" {} Hz", config::shortest(log_rate_hz));
  const std::string loop = fmt::format("controller \"{}\", {} Hz", controller, config::shortest(loop_rate_hz));
  if (ticks < 1.0 - 1e-9)
    throw ParameterError("log_rate_hz",
                         fmt::format("{} is above the rate of {} (it has no more rows); write log_rate_hz = {:.12g}",
                                     says, loop, loop_rate_hz));
  if (whole > 1.0 && whole >= flight_ticks)
    throw ParameterError("log_rate_hz", fmt::format("{} leaves one row of a flight of {} s (the next would come after "
                                                    "its end); fly longer, or log more often",
                                                    says, config::shortest(flight_ticks / loop_rate_hz)));
  if (std::abs(ticks - whole) > 1e-9 * whole)
    throw ParameterError("log_rate_hz",
                         fmt::format("{} does not divide the rate of {} (steps between rows would be "
                                     "unequal); write log_rate_hz = {:.12g} or {:.12g}",
                                     says, loop, loop_rate_hz / std::ceil(ticks), loop_rate_hz / std::floor(ticks)));
  return static_cast<std::int64_t>(whole);
}

// at rest at the trajectory's start, heading along it, rotors at the speed that carries the weight
VehicleState start_state(const Trajectory& trajectory, const VehicleModel& vehicle) {
  VehicleState state;
  state.position_W_m = trajectory.start_position_W_m();
  state.attitude_WB = Eigen::AngleAxisd(trajectory.at(0.0).yaw_rad, Vector3::UnitZ());
  std::fill_n(state.rotor_speed_radps.begin(), vehicle.rotor_count, vehicle.hover_speed_radps());
  return state;
}

bool is_finite(const RotorCommand& command) {
  double sum = 0.0;
  for (const double speed : command.speed_radps) sum += speed;
  return std::isfinite(sum);
}

// a reference that stands
Reference position_of(const Reference& moving) {
  Reference standing;
  standing.position_W_m = moving.position_W_m;
  standing.yaw_rad = moving.yaw_rad;
  return standing;
}

// The offboard link: what is measured aboard now, with pose and velocity of the newest message that arrived, and the set point of
// the last that was not lost. The first message is there from the start.
class OffboardLink {
 public:
  explicit OffboardLink(Flight& flight)
      : flight_(flight),
        sent_(flight.link_messages),
        full_(flight.options.set_points == "full"),
        random_(flight.options.offboard_jitter_s > 0.0 || flight.options.offboard_dropout > 0.0),
        wired_(flight.ticks_per_offboard == 1 && flight.options.offboard_delay_s == 0.0 && !random_) {}

  void send(const Observation& seen, const Reference& set_point, std::int64_t tick) {
    if (wired_) reference_ = full_ ? set_point : position_of(set_point);
    if (wired_ || tick % flight_.ticks_per_offboard != 0) return;
    const std::int64_t number = tick / flight_.ticks_per_offboard;
    const FlightOptions& link = flight_.options;
    const auto [lost, late, unused, unused_too] =
        random_ ? flight_.link_stream.uniform4(static_cast<std::uint64_t>(number)) : std::array<double, 4>{};
    const double age_s = number == 0 ? 0.0 : link.offboard_delay_s + late * link.offboard_jitter_s;
    const bool is_lost = random_ && number > 0 && lost < link.offboard_dropout;
    message(number) = {is_lost ? std::numeric_limits<std::int64_t>::max() : tick + std::llround(age_s / flight_.tick_s),
                       seen.pose_time_s, seen.position_W_m, seen.velocity_W_mps};
    if (!is_lost) reference_ = full_ ? set_point : position_of(set_point);
    newest_ = number;
  }

  Observation over(Observation seen, std::int64_t tick) {
    if (wired_) return seen;
    const auto oldest = std::max<std::int64_t>(0, newest_ + 1 - static_cast<std::int64_t>(sent_.size()));
    for (std::int64_t number = newest_; number >= oldest; --number) {
      const LinkMessage& sent = message(number);
      // an older one that comes in later is of no use
      if (sent.time_s < arrived_.time_s) break;
      if (sent.arrival_tick > tick) continue;
      arrived_ = sent;
      break;
    }
    seen.pose_time_s = arrived_.time_s;
    seen.position_W_m = arrived_.position_W_m;
    seen.velocity_W_mps = arrived_.velocity_W_mps;
    return seen;
  }

  const Reference& reference() const { return reference_; }

 private:
  LinkMessage& message(std::int64_t number) { return sent_[static_cast<std::size_t>(number) % sent_.size()]; }

  Flight& flight_;
  std::vector<LinkMessage>& sent_;
  const bool full_, random_;
  const bool wired_;  // everything arrives at once: nothing to keep
  std::int64_t newest_ = 0;
  LinkMessage arrived_{0, -std::numeric_limits<double>::infinity()};
  Reference reference_;
};

Plant::Options plant_options(const Experiment& experiment, const RunSpec& spec) {
  return {experiment.flight.step_s, static_cast<std::uint64_t>(experiment.seed), spec.replicate,
          experiment.speed_is_logged};
}

}  // namespace

std::string_view to_string(Outcome outcome) {
  return std::find_if(outcome_names.begin(), outcome_names.end(),
                      [&](const auto& name) { return name.first == outcome; })
      ->second;
}

std::optional<Outcome> find_outcome(std::string_view text) {
  for (const auto& [outcome, name] : outcome_names)
    if (name == text) return outcome;
  return std::nullopt;
}

Flight::Flight(const Experiment& experiment, const RunSpec& spec)
    : options(experiment.flight),
      plant(experiment.vehicle, make_flown_effects(experiment.effects), plant_options(experiment, spec)) {
  const Choice& path = experiment.trajectories[spec.trajectory];
  trajectory = find_trajectory(path.spec.type)->make();
  config::read_parameters(path.spec, *trajectory);
  config::at_place(path.spec, [&] { trajectory->prepare(); });
  if (options.laps > 0.0 && options.duration_s > 0.0)
    throw ParameterError("laps",
                         "\"laps\" stands beside \"duration_s\" (either says how long the flight is); keep one");
  if (options.laps > 0.0 && trajectory->lap_s() <= 0.0)
    throw ParameterError("laps", fmt::format("trajectory \"{}\" has no laps", path.name));
  manoeuvre_s = options.laps > 0.0         ? options.laps * trajectory->lap_s()
                : options.duration_s > 0.0 ? options.duration_s
                                           : trajectory->duration_s();
  if (manoeuvre_s <= 0.0)
    throw ParameterError("duration_s",
                         fmt::format("trajectory \"{}\" has no natural end, and \"duration_s\" is missing", path.name));
  options.duration_s = options.hover_before_s + manoeuvre_s + options.hover_after_s;
  if (options.set_points != "full" && options.set_points != "position")
    throw ParameterError("set_points", "set_points = \"" + options.set_points +
                                           "\" is unknown (what reaches the controller); use full or position");

  const Choice& law = experiment.controllers[spec.controller];
  controller = find_controller(law.spec.type)->make();
  config::read_parameters(law.spec, *controller);
  const double rate_hz = config::at_place(law.spec, [&] { return controller->rate_hz(experiment.vehicle); });
  const double period_s = 1.0 / rate_hz;
  const std::string period_says = fmt::format("the period of controller \"{}\",", law.name);
  steps_per_tick =
      divide("step_s", period_s, options.step_s, period_says, "\"step_s\"",
             fmt::format("; write step_s = {}", config::shortest(period_s / std::ceil(period_s / options.step_s))));
  if (options.offboard_rate_hz > 0.0)
    ticks_per_offboard = divide("offboard_rate_hz", 1.0 / options.offboard_rate_hz, period_s,
                                "the period of \"offboard_rate_hz\",", period_says);
  tick_s = period_s;
  rotors = static_cast<std::size_t>(experiment.vehicle.rotor_count);
  link_stream = RandomStream(static_cast<std::uint64_t>(experiment.seed), spec.replicate, "offboard link");
  const double longest_s = options.offboard_delay_s + options.offboard_jitter_s;
  link_messages.resize(static_cast<std::size_t>(longest_s / (period_s * static_cast<double>(ticks_per_offboard))) + 3);
  ticks = static_cast<std::int64_t>(std::round(options.duration_s / period_s));
  if (experiment.log.log_rate_hz > 0.0)
    ticks_per_row = ticks_of_row(experiment.log.log_rate_hz, rate_hz, law.name, static_cast<double>(ticks));

  plant.reset(start_state(*trajectory, experiment.vehicle));
  setup = {experiment.vehicle, period_s};
  const Observation first = plant.observe(true);
  config::at_place(law.spec, [&] { controller->reset(setup, first); });
  hand_over_tick = static_cast<std::int64_t>(std::round(options.hand_over_s / period_s));
  if (hand_over_tick > 0 && hand_over_tick >= ticks)
    throw ParameterError("hand_over_s",
                         fmt::format("\"hand_over_s\" leaves nothing to fly for controller \"{}\" (it is not shorter "
                                     "than the flight, {} s)",
                                     law.name, config::shortest(options.duration_s)));
  if (hand_over_tick > 0) {
    first_controller = find_controller("pid")->make();
    first_controller->reset(setup, first);
  }
}

Reference Flight::reference_at(double time_s) const {
  if (options.hover_before_s + options.hover_after_s == 0.0) return trajectory->at(time_s);
  const double since_s = time_s - options.hover_before_s;
  if (since_s >= 0.0 && since_s <= manoeuvre_s) return trajectory->at(since_s);
  Reference standing = position_of(trajectory->at(std::clamp(since_s, 0.0, manoeuvre_s)));
  if (since_s < 0.0) standing.position_W_m = trajectory->start_position_W_m();
  return standing;
}

std::vector<NamedValue> arcs_of(const Experiment& experiment) {
  constexpr double interval_s = 0.01;
  std::vector<NamedValue> arcs;
  RunSpec spec;
  for (spec.trajectory = 0; spec.trajectory < experiment.trajectories.size(); ++spec.trajectory) {
    const Flight flight(experiment, spec);
    const double duration_s = flight.manoeuvre_s, lap_s = flight.trajectory->lap_s();
    double length_m = 0.0;
    for (std::int64_t k = 0; static_cast<double>(k + 1) * interval_s <= duration_s + 1e-9; ++k)
      length_m += (flight.trajectory->at(static_cast<double>(k + 1) * interval_s).position_W_m -
                   flight.trajectory->at(static_cast<double>(k) * interval_s).position_W_m)
                      .norm();
    const auto hover = [](double hover_s, std::string_view when) {
      return hover_s > 0.0 ? fmt::format(", {} s of hover {}", config::shortest(hover_s), when) : std::string();
    };
    arcs.push_back(
        {experiment.trajectories[spec.trajectory].name,
         fmt::format("{} s, {:.1f} m{}{}{}", config::shortest(duration_s), length_m,
                     lap_s > 0.0 ? fmt::format(", {:.2f} laps", duration_s / lap_s) : "",
                     hover(flight.options.hover_before_s, "before"), hover(flight.options.hover_after_s, "after"))});
  }
  return arcs;
}

FlightEnd fly(Flight& flight, TrackingError& error, FlightRecorder* recorder, Effort* effort) {
  Plant& plant = flight.plant;
  const bool with_accelerometer = flight.controller->uses_accelerometer() || recorder != nullptr;
  const double max_error_m2 = flight.options.max_error_m * flight.options.max_error_m;
  const double max_speed_m2ps2 = flight.options.max_speed_mps * flight.options.max_speed_mps;
  OffboardLink link(flight);

  for (std::int64_t tick = 0; tick < flight.ticks; ++tick) {
    if (flight.at_interrupt == AtInterrupt::end) throw_if_interrupted();
    const VehicleState& truth = plant.state();
    const Reference here = flight.reference_at(truth.time_s);
    error.add(truth.time_s, truth.position_W_m, here.position_W_m);
    if (effort != nullptr) effort->add(truth.time_s, {truth.rotor_speed_radps.data(), flight.rotors});

    const Observation measured = plant.observe(with_accelerometer);
    link.send(measured, here, tick);
    const Observation seen = link.over(measured, tick);
    if (tick == flight.hand_over_tick && tick > 0) flight.controller->reset(flight.setup, seen);
    Controller& controller = tick < flight.hand_over_tick ? *flight.first_controller : *flight.controller;
    const RotorCommand command = controller.update(seen, link.reference());
    if (!is_finite(command)) return {Outcome::controller_nonfinite, truth.time_s};
    if (recorder != nullptr) recorder->append(flight, measured, here, command);

    if ((truth.position_W_m - here.position_W_m).squaredNorm() > max_error_m2 ||
        truth.velocity_W_mps.squaredNorm() > max_speed_m2ps2)
      return {Outcome::left_envelope, truth.time_s};
    for (std::int64_t step = 0; step < flight.steps_per_tick; ++step) {
      if (!plant.step(command)) return {Outcome::diverged, truth.time_s};
      if (plant.touches_ground()) return {Outcome::crashed, truth.time_s};
    }
  }
  return {Outcome::completed, plant.state().time_s};
}

RunRecord run(const Experiment& experiment, const RunSpec& spec, AtInterrupt at_interrupt) {
  Flight flight(experiment, spec);
  flight.at_interrupt = at_interrupt;
  TrackingError error(flight.options.settle_s, static_cast<std::size_t>(flight.ticks));
  Effort effort(flight.options.settle_s, flight.tick_s);
  const FlightEnd end = fly(flight, error, nullptr, &effort);
  return {spec, end.outcome, end.time_s, error.figures(), effort.figures()};
}

}  // namespace gustlab
