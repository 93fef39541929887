#include "simulation/recorded_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "gustlab/errors.hpp"
#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/rotor_speed.hpp"

namespace gustlab {
namespace {

constexpr double actuation_step_s = 0.001;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// the vehicle's own effects; of thrust alone only those between command and rotor
std::vector<NamedEffect> known_effects(const VehicleModel& vehicle, Known known) {
  std::vector<NamedEffect> effects = make_effects(vehicle.effects);
  if (known == Known::thrust)
    std::erase_if(effects, [](const NamedEffect& e) { return e.row->place != Place::actuation; });
  return effects;
}

// a row of rotor1…rotorN or u1…uN; false when a cell is empty
bool read_row(const std::vector<const std::vector<double>*>& columns, std::size_t row, RotorArray& out) {
  bool complete = true;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    out[i] = (*columns[i])[row];
    complete = complete && std::isfinite(out[i]);
  }
  return complete;
}

std::vector<const std::vector<double>*> rotor_columns(const FlightLog& log, std::string_view prefix) {
  std::vector<const std::vector<double>*> columns;
  for (int i = 1; i <= log.count(prefix); ++i) columns.push_back(log.find(fmt::format("{}{}", prefix, i)));
  return columns;
}

// the speeds that a row of inputs asks for; false when it says nothing
bool read_command(const FlightLog& log, const VehicleModel& vehicle,
                  const std::vector<const std::vector<double>*>& columns, std::size_t row, RotorArray& speed_radps) {
  RotorArray input{};
  if (!read_row(columns, row, input)) return false;
  const bool collective = log.meta.actuator == ActuatorKind::collective_thrust;
  speed_radps = speeds_radps(vehicle, log.meta.actuator, [&](std::size_t i) { return input[collective ? 0 : i]; });
  return true;
}

// rotor speeds that the inputs lead to, through the vehicle's delay, lag and limits
std::vector<RotorArray> driven_speeds(const FlightLog& log, const VehicleModel& vehicle, Known known) {
  const auto columns = rotor_columns(log, "u");
  Plant plant(vehicle, known_effects(vehicle, known), {.step_s = actuation_step_s});
  std::vector<RotorArray> speeds(log.rows());
  RotorArray last{}, next{};
  bool started = false;
  std::int64_t done = 0;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    speeds[row].fill(nan);
    if (!read_command(log, vehicle, columns, row, next)) {
      if (!started) continue;
      next = last;
    }
    const auto until = static_cast<std::int64_t>(std::llround((log.time_s[row] - log.time_s[0]) / actuation_step_s));
    if (!started) {
      VehicleState start;
      start.rotor_speed_radps = next;
      plant.reset(start);
      started = true;
      done = until;
    }
    done = std::max(done, until - static_cast<std::int64_t>(longest_walk_s / actuation_step_s));
    // a held command acts from its row on; any other is taken to move straight from row to row
    for (std::int64_t step = done + 1; step <= until; ++step) {
      const double share = static_cast<double>(step - done) / static_cast<double>(until - done);
      RotorCommand command{last};
      if (log.meta.hold != Hold::zoh) {
        for (std::size_t i = 0; i < next.size(); ++i) command.speed_radps[i] += share * (next[i] - last[i]);
      }
      plant.advance_actuation(command);
    }
    done = until;
    last = next;
    speeds[row] = plant.state().rotor_speed_radps;
  }
  return speeds;
}

std::vector<RotorArray> speeds(const FlightLog& log, const VehicleModel& vehicle, Known known) {
  const int measured = log.count("rotor"), inputs = log.count("u");
  const int wanted = measured > 0 || log.meta.actuator != ActuatorKind::collective_thrust ? vehicle.rotor_count : 1;
  const int found = measured > 0 ? measured : inputs;
  if (found != wanted) {
    throw DataError(fmt::format("{}:1:1: {} {} columns (vehicle {} needs {}); check vehicle and columns", log.path,
                                found, measured > 0 ? "rotor" : "u", vehicle.name, wanted));
  }
  if (measured == 0) return driven_speeds(log, vehicle, known);
  const auto columns = rotor_columns(log, "rotor");
  std::vector<RotorArray> out(log.rows());
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (!read_row(columns, row, out[row])) out[row].fill(nan);
  }
  return out;
}

}  // namespace

RecordedForces::RecordedForces(const FlightLog& log, const VehicleModel& vehicle, Known known)
    : forces_(vehicle, known_effects(vehicle, known)),
      speed_radps_(speeds(log, vehicle, known)),
      voltage_V_(log.rows(), 0.0) {
  forces_.prepare(actuation_step_s, 1, 1);
  memory_.resize(static_cast<std::size_t>(forces_.state_size()));
  forces_.reset_state(memory_);
  const std::vector<double>* voltage = log.find("vbat");
  for (std::size_t row = 0; voltage != nullptr && row < log.rows(); ++row) {
    const double before = row > 0 ? voltage_V_[row - 1] : 0.0;
    voltage_V_[row] = std::isfinite((*voltage)[row]) ? (*voltage)[row] : before;
  }
}

RecordedForces::Force RecordedForces::at(std::size_t row, const VehicleState& state) const {
  Flow flow = forces_.flow(state, voltage_V_[row]);
  RotorSet rotors;
  forces_.rotors(speed_radps_[row], RotorArray{}, flow, rotors);
  Force out;
  out.force_B_N = forces_.wrench(flow, rotors, memory_).force_B_N;
  for (int i = 0; i < rotors.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    out.thrust_N += rotors.thrust_N[k] * rotors.axis_B[k].z();
  }
  return out;
}

}  // namespace gustlab
