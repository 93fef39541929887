#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "config/json_text.hpp"
#include "plant/bare_step.hpp"
#include "simulation/experiment.hpp"
#include "sweep/sweep.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

struct BenchArguments {
  std::string experiment = "table2_crazyflie", format = "md";
  int rounds = 5;
};

// one controller in every run that the experiment plans for it, by `gustlab sweep`: planning, flying, metrics, the store
struct BenchRow {
  std::string controller;
  Experiment experiment;
  double steps = 0.0;
  double cpu_ns, one_thread_ns,
      two_threads_ns;  // least of all rounds, of the whole sweep: CPU time, and time by the clock
};

struct Bench {
  double minimal_step_ns, stock_step_ns;
  std::vector<BenchRow> rows;
};

// of all threads; what else the machine does is not in it
double cpu_now_ns() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

template <class Function>
void keep_least(double& cpu_ns, double& clock_ns, Function function) {
  throw_if_interrupted();
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start_ns = cpu_now_ns();
  function();
  cpu_ns = std::min(cpu_ns, cpu_now_ns() - cpu_start_ns);
  clock_ns =
      std::min(clock_ns, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
}

void fly(BenchRow& row, int jobs) {
  const ScratchFolder scratch(std::filesystem::temp_directory_path());
  const std::string out = (scratch.path() / "sweep").string();
  sweep(row.experiment, {out, {}, jobs}, interrupted(), [](std::size_t, std::size_t) {});
  throw_if_interrupted();
  if (row.steps > 0.0) return;
  for (const ResultRow& flown : read_results(out).rows) row.steps += flown.duration_s / row.experiment.flight.step_s;
}

// what is compared takes turns, so that what else the machine does hits all alike
Bench measure(const BenchArguments& options) {
  constexpr double none = std::numeric_limits<double>::infinity();
  constexpr int bare_steps = 200000;
  const std::string path = find_experiment(options.experiment);
  Bench bench{none, none, {}};
  const Experiment whole = read_experiment(path);
  for (const Choice& controller : whole.controllers)
    bench.rows.push_back({controller.name,
                          read_experiment(path, {fmt::format("controllers=[\"{}\"]", controller.name)}), 0.0, none,
                          none, none});
  BareStep minimal(BareStep::Model::minimal, whole.flight.step_s), stock(BareStep::Model::stock, whole.flight.step_s);
  double unused_ns = none;
  for (int round = 0; round < options.rounds; ++round) {
    keep_least(bench.stock_step_ns, unused_ns, [&] { stock.step(bare_steps); });
    for (BenchRow& row : bench.rows) {
      keep_least(bench.minimal_step_ns, unused_ns, [&] { minimal.step(bare_steps); });
      keep_least(row.cpu_ns, row.one_thread_ns, [&] { fly(row, 1); });
      keep_least(unused_ns, row.two_threads_ns, [&] { fly(row, 2); });
    }
  }
  bench.minimal_step_ns /= bare_steps;
  bench.stock_step_ns /= bare_steps;
  return bench;
}

void print_json(const Bench& bench, const std::string& experiment) {
  nlohmann::ordered_json report{{"format", "gustlab-bench/1"},
                                {"experiment", experiment},
                                {"minimal_step_ns", bench.minimal_step_ns},
                                {"stock_step_ns", bench.stock_step_ns}};
  for (const BenchRow& row : bench.rows) {
    const double step_ns = row.cpu_ns / row.steps;
    report["controllers"].push_back({{"controller", row.controller},
                                     {"steps", row.steps},
                                     {"step_ns", step_ns},
                                     {"over_minimal", step_ns / bench.minimal_step_ns},
                                     {"two_threads_factor", row.one_thread_ns / row.two_threads_ns}});
  }
  fmt::print("{}\n", config::json_text(report, 2));
}

void print_table(const Bench& bench, const std::string& experiment) {
  fmt::print("| a step of | CPU time [ns] | over minimal | two threads |\n|---|--:|--:|--:|\n");
  fmt::print("| mj_step, minimal model | {:.0f} | 1.00 | |\n", bench.minimal_step_ns);
  fmt::print("| mj_step, stock model | {:.0f} | {:.2f} | |\n", bench.stock_step_ns,
             bench.stock_step_ns / bench.minimal_step_ns);
  for (const BenchRow& row : bench.rows) {
    const double step_ns = row.cpu_ns / row.steps;
    fmt::print("| sweep {}, {} | {:.0f} | {:.2f} | {:.2f} × |\n", experiment, row.controller, step_ns,
               step_ns / bench.minimal_step_ns, row.one_thread_ns / row.two_threads_ns);
  }
}

}  // namespace

void add_bench(CLI::App& app) {
  const auto options = std::make_shared<BenchArguments>();
  CLI::App* command = app.add_subcommand("bench", "measures a sweep per controller against a bare MuJoCo step");
  command->add_option("EXPERIMENT", options->experiment, "a TOML file, or its name under experiments/")
      ->capture_default_str();
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "json"}))->capture_default_str();
  command->add_option("--rounds", options->rounds, "the best of so many counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->callback([options] {
    interrupted();
    const Bench bench = measure(*options);
    if (options->format == "json") print_json(bench, options->experiment);
    else print_table(bench, options->experiment);
  });
}

}  // namespace gustlab
