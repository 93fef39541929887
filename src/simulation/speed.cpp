#include "simulation/speed.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

#include "plant/bare_step.hpp"
#include "simulation/flight.hpp"
#include "util/parallel.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab {

namespace {

template <class Function>
double time_ns(Function function) {
  const auto start = std::chrono::steady_clock::now();
  function();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
}

EffectSpec effect(const std::string& type, std::vector<std::pair<std::string, std::string>> values) {
  EffectSpec spec;
  spec.type = type;
  spec.values = std::move(values);
  return spec;
}

Choice choice(const std::string& type) {
  Choice one{type, {}};
  one.spec.type = type;
  return one;
}

}  // namespace

Experiment speed_experiment() {
  Experiment experiment;
  experiment.name = "speed";
  experiment.vehicle_name = "crazyflie";
  experiment.vehicle = read_vehicle("crazyflie");
  experiment.vehicle.environment.ground_z_m = 0.0;
  experiment.trajectories = {choice("circle")};
  experiment.controllers = {choice("pid")};
  experiment.effects = {effect("motor_lag", {{"time_constant", "0.0125"}, {"time_constant_down", "0.025"}}),
                        effect("gust", {{"sigma_xy", "0.03"}, {"correlation_time", "1.0"}, {"limit_N", "0.065"}})};
  experiment.replicates = 4;
  experiment.flight.duration_s = 40.0;
  return experiment;
}

Speed measure_speed(int rounds) {
  constexpr int bare_steps = 50000;
  const Experiment experiment = speed_experiment();
  const std::vector<RunSpec> runs = plan(experiment);
  BareStep minimal(BareStep::Model::minimal), stock(BareStep::Model::stock);
  const double loop_steps = experiment.flight.duration_s / experiment.flight.step_s;
  const auto fly_runs = [&](int jobs) {
    parallel_for(static_cast<std::int64_t>(runs.size()), jobs, [&](std::int64_t i) { run(experiment, runs[static_cast<std::size_t>(i)]); });
  };

  constexpr double none = std::numeric_limits<double>::infinity();
  double minimal_ns = none, stock_ns = none, loop_ns = none, one_ns = none, two_ns = none;
  for (int round = 0; round < rounds; ++round) {
    minimal_ns = std::min(minimal_ns, time_ns([&] { minimal.step(bare_steps); }) / bare_steps);
    Flight flight(experiment, runs.front());
    TrackingError error(0.0, static_cast<std::size_t>(flight.ticks));
    loop_ns = std::min(loop_ns, time_ns([&] { fly(flight, error, nullptr); }) / loop_steps);
    stock_ns = std::min(stock_ns, time_ns([&] { stock.step(bare_steps); }) / bare_steps);
    one_ns = std::min(one_ns, time_ns([&] { fly_runs(1); }));
    two_ns = std::min(two_ns, time_ns([&] { fly_runs(2); }));
  }
  return {minimal_ns, stock_ns, loop_ns, one_ns / two_ns};
}

}  // namespace gustlab
