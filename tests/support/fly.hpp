// A tiny closed loop for tests of controllers: plant, controller, reference, and a gust made of two sines.
#pragma once

#include <cmath>
#include <functional>
#include <memory>

#include "effects/effects.hpp"
#include "gustlab/controller.hpp"
#include "gustlab/trajectory.hpp"
#include "plant/plant.hpp"
#include "support/parameters.hpp"
#include "support/vehicles.hpp"

namespace gustlab::test {

// a force given as a function of time, world axes
class ForceEffect final : public Effect {
 public:
  using Force = std::function<Vector3(double)>;
  explicit ForceEffect(Force force) : force_(std::move(force)) {}
  void visit(ParameterVisitor&) override {}
  void wrench(const Flow& flow, const RotorSet&, std::span<const double>, Wrench& total) const override {
    total.force_B_N += flow.R_WB.transpose() * force_(flow.time_s);
  }

 private:
  Force force_;
};

inline constexpr EffectRow test_force_row{.name = "test_force",
                                          .place = Place::wrench,
                                          .order = 10,
                                          .per_flight = true,
                                          .diagnosable = false,
                                          .external = true,
                                          .says = "",
                                          .shows_in = "",
                                          .confused_with = "",
                                          .source = "",
                                          .make = nullptr};

struct ControllerFlight {
  Controller* controller = nullptr;
  const Trajectory* trajectory = nullptr;
  VehicleModel vehicle;
  double duration_s = 10.0;
  double settle_s = 0.0;
  int steps_per_tick = 1;
  ForceEffect::Force force;  // empty: none
  Quaternion start_attitude_WB = Quaternion::Identity();
  std::function<void(Observation&)> sensor;  // what happens to an observation on its way
  std::function<void(const RotorCommand&)> heard;
};

struct ControllerFlightEnd {
  bool finite = true;
  double rmse_xy_m = 0.0, rmse_z_m = 0.0, max_m = 0.0, final_error_m = 0.0, final_tilt_rad = 0.0;
  VehicleState last;
};

// effects of the vehicle file, set by the visitor
inline std::vector<NamedEffect> vehicle_effects(const VehicleModel& vehicle) {
  std::vector<NamedEffect> effects;
  for (const EffectSpec& spec : vehicle.effects) {
    const EffectRow* row = find_effect(spec.type);
    NamedEffect named{row, row->make()};
    for (const auto& [key, value] : spec.values) set_number(*named.effect, key, std::stod(value));
    effects.push_back(std::move(named));
  }
  return effects;
}

inline ControllerFlightEnd fly(const ControllerFlight& flight) {
  const double period_s = 1.0 / flight.controller->rate_hz(flight.vehicle);
  std::vector<NamedEffect> effects = vehicle_effects(flight.vehicle);
  if (flight.force) effects.push_back({&test_force_row, std::make_unique<ForceEffect>(flight.force)});
  Plant plant(flight.vehicle, std::move(effects), {.step_s = period_s / flight.steps_per_tick});

  VehicleState start;
  start.position_W_m = flight.trajectory->start_position_W_m();
  start.attitude_WB = flight.start_attitude_WB;
  for (int i = 0; i < flight.vehicle.rotor_count; ++i)
    start.rotor_speed_radps[static_cast<std::size_t>(i)] = flight.vehicle.hover_speed_radps();
  plant.reset(start);

  const bool accelerometer = flight.controller->uses_accelerometer();
  const auto observe = [&] {
    Observation observation = plant.observe(accelerometer);
    if (flight.sensor) flight.sensor(observation);
    return observation;
  };
  flight.controller->reset({flight.vehicle, period_s}, observe());

  ControllerFlightEnd result;
  double sum_xy = 0.0, sum_z = 0.0;
  int samples = 0;
  const int ticks = static_cast<int>(std::lround(flight.duration_s / period_s));
  for (int tick = 0; tick < ticks; ++tick) {
    const double time_s = tick * period_s;
    const Reference reference = flight.trajectory->at(time_s);
    const RotorCommand command = flight.controller->update(observe(), reference);
    const Vector3 error = plant.state().position_W_m - reference.position_W_m;
    if (time_s >= flight.settle_s) {
      sum_xy += error.head<2>().squaredNorm();
      sum_z += error.z() * error.z();
      result.max_m = std::max(result.max_m, error.norm());
      ++samples;
    }
    result.final_error_m = error.norm();
    if (flight.heard) flight.heard(command);
    for (int step = 0; step < flight.steps_per_tick; ++step) result.finite = result.finite && plant.step(command);
    if (!result.finite) break;
  }
  result.last = plant.state();
  result.rmse_xy_m = std::sqrt(sum_xy / std::max(samples, 1));
  result.rmse_z_m = std::sqrt(sum_z / std::max(samples, 1));
  const Vector3 up = result.last.attitude_WB * Vector3::UnitZ();
  result.final_tilt_rad = std::acos(std::clamp(up.z(), -1.0, 1.0));
  return result;
}

// a gust of the paper's size: for a weight mg, horizontal force of a few percent to a quarter of it, bounded
inline ForceEffect::Force gust(double size_N) {
  return [size_N](double t) {
    return Vector3(size_N * (std::sin(0.9 * t) + 0.6 * std::sin(2.3 * t + 0.7)),
                   size_N * (std::sin(0.7 * t + 1.1) + 0.6 * std::sin(2.9 * t)), 0.2 * size_N * std::sin(1.7 * t));
  };
}

}  // namespace gustlab::test
