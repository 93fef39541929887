#include "simulation/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "config/toml.hpp"
#include "flight_log/write_flight_log.hpp"
#include "gustlab/errors.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

// Of the log of a whole flight. Throws ConfigError where they are too many.
std::size_t log_rows(const Experiment& experiment, const Flight& flight) {
  const auto ticks = static_cast<double>(flight.ticks);
  const double rows = std::ceil(ticks / static_cast<double>(flight.ticks_per_row));
  if (rows > most_log_rows)
    throw ConfigError(worded(
        fmt::format("{}: a flight log of {:.0f} rows is too long", experiment.name, rows),
        fmt::format("the most are {:.0f}", most_log_rows),
        fmt::format("fly less than {} s, or log_rate_hz = {:.12g} at most", config::shortest(flight.options.duration_s),
                    1.0 / (flight.tick_s * std::ceil(ticks / most_log_rows)))));
  return static_cast<std::size_t>(rows);
}

}  // namespace

FlightRecorder::FlightRecorder(const Experiment& experiment, Flight& flight)
    : truth_(experiment.log.log_source == "truth"),
      ticks_per_row_(flight.ticks_per_row),
      rotors_(static_cast<std::size_t>(experiment.vehicle.rotor_count)) {
  log_.meta.vehicle = experiment.vehicle_name;
  log_.meta.actuator = ActuatorKind::rotor_speed;
  log_.meta.source = "simulation";
  log_.meta.hold = Hold::zoh;
  log_.meta.environment = experiment.vehicle.environment;

  std::vector<std::string> names{"px", "py", "pz", "vx", "vy", "vz", "qw", "qx",
                                 "qy", "qz", "wx", "wy", "wz", "ax", "ay", "az"};
  for (const char* prefix : {"u", "rotor"})
    for (std::size_t i = 1; i <= rotors_; ++i) names.push_back(prefix + std::to_string(i));
  for (const char* name : {"rpx", "rpy", "rpz", "rvx", "rvy", "rvz", "rax", "ray", "raz", "ryaw", "fx", "fy", "fz",
                           "tx", "ty", "tz", "awx", "awy", "awz"})
    names.emplace_back(name);
  for (const std::string_view name : flight.controller->telemetry_names()) names.emplace_back(name);
  telemetry_.resize(flight.controller->telemetry_names().size());

  const std::size_t rows = log_rows(experiment, flight);
  log_.time_s.reserve(rows);
  for (std::string& name : names) {
    log_.columns.push_back({std::move(name), {}});
    log_.columns.back().values.reserve(rows);
  }
}

void FlightRecorder::add(const Vector3& value) {
  for (const double component : value) add(component);
}

void FlightRecorder::append(Flight& flight, const Observation& measured, const Reference& reference,
                            const RotorCommand& command) {
  const VehicleState& truth = flight.plant.state();
  if (tick_++ % ticks_per_row_ != 0) return;

  column_ = 0;
  log_.time_s.push_back(truth.time_s);
  add(truth_ ? truth.position_W_m : measured.position_W_m);
  add(truth_ ? truth.velocity_W_mps : measured.velocity_W_mps);
  const Quaternion& attitude = truth_ ? truth.attitude_WB : measured.attitude_WB;
  for (const double component : {attitude.w(), attitude.x(), attitude.y(), attitude.z()}) add(component);
  add(truth_ ? truth.body_rate_B_radps : measured.body_rate_B_radps);
  add(measured.specific_force_B_mps2);
  for (std::size_t i = 0; i < rotors_; ++i) add(command.speed_radps[i]);
  for (std::size_t i = 0; i < rotors_; ++i) add(truth_ ? truth.rotor_speed_radps[i] : measured.rotor_speed_radps[i]);
  add(reference.position_W_m);
  add(reference.velocity_W_mps);
  add(reference.acceleration_W_mps2);
  add(reference.yaw_rad);

  const Wrench disturbance = flight.plant.disturbance();
  const Vector3 force_W_N = truth.attitude_WB * disturbance.force_B_N;
  add(force_W_N);
  add(disturbance.torque_B_Nm);
  add(force_W_N / flight.plant.forces().vehicle().mass_kg);
  flight.controller->telemetry(telemetry_);
  for (const double value : telemetry_) add(value);
}

FlightLog FlightRecorder::take() {
  // between the rows of a slower log the command changes, and nobody knows how
  if (ticks_per_row_ > 1) log_.meta.hold = Hold::unknown;
  return std::move(log_);
}

void check_log_rows(const Experiment& experiment, const RunSpec& spec) {
  log_rows(experiment, Flight(experiment, spec));
}

LoggedRun run_logged(const Experiment& experiment, const RunSpec& spec, AtInterrupt at_interrupt) {
  Flight flight(experiment, spec);
  flight.at_interrupt = at_interrupt;
  FlightRecorder recorder(experiment, flight);
  TrackingError error(flight.options.settle_s, static_cast<std::size_t>(flight.ticks));
  Effort effort(flight.options.settle_s, flight.tick_s);
  const FlightEnd end = fly(flight, error, &recorder, &effort);
  return {{spec, end.outcome, end.time_s, error.figures(), effort.figures()}, recorder.take()};
}

void write_run_log(FlightLog log, const Experiment& experiment, const std::string& csv_path, AtInterrupt at_interrupt) {
  if (experiment.vehicle_name.find_first_of("/.") != std::string::npos)
    log.meta.vehicle =
        std::filesystem::proximate(experiment.vehicle.source_path, std::filesystem::path(csv_path).parent_path())
            .string();
  if (at_interrupt == AtInterrupt::end) write_flight_log(log, csv_path, throw_if_interrupted);
  else write_flight_log(log, csv_path);
}

}  // namespace gustlab
