// A step of the closed loop beside MuJoCo's own: the figures of docs/PROMISES.md. `gustlab bench` prints their ratios.
#include <benchmark/benchmark.h>

#include "plant/bare_step.hpp"
#include "simulation/flight.hpp"

namespace {

using namespace gustlab;

void bare_step(benchmark::State& state, BareStep::Model model) {
  BareStep bare(model);
  for (auto _ : state) bare.step(1);
}
BENCHMARK_CAPTURE(bare_step, minimal, BareStep::Model::minimal);
BENCHMARK_CAPTURE(bare_step, stock, BareStep::Model::stock);

const Experiment& table2_pid() {
  static const Experiment experiment = read_experiment(find_experiment("table2_crazyflie"), {"controllers=[\"pid\"]"});
  return experiment;
}

// items are steps
void closed_loop(benchmark::State& state) {
  const Experiment& experiment = table2_pid();
  const RunSpec spec = plan(experiment).front();
  std::int64_t steps = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Flight flight(experiment, spec);
    TrackingError error(0.0, static_cast<std::size_t>(flight.ticks));
    state.ResumeTiming();
    benchmark::DoNotOptimize(fly(flight, error, nullptr));
    steps += flight.ticks * flight.steps_per_tick;
  }
  state.SetItemsProcessed(steps);
}
BENCHMARK(closed_loop)->Unit(benchmark::kMillisecond);

// whole runs, set-up included, on one and on two threads
void whole_runs(benchmark::State& state) {
  const Experiment& experiment = table2_pid();
  static const RunSpec spec = plan(experiment).front();
  for (auto _ : state) benchmark::DoNotOptimize(run(experiment, spec));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(whole_runs)->Unit(benchmark::kMillisecond)->Threads(1)->Threads(2)->UseRealTime();

}  // namespace
