#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "simulation/speed.hpp"

namespace gustlab {

namespace {

void bench(const std::string& format, int rounds) {
  const Speed speed = measure_speed(rounds);
  const double over_minimal = speed.loop_step_ns / speed.minimal_step_ns, over_stock = speed.loop_step_ns / speed.stock_step_ns;
  if (format == "json") {
    const nlohmann::ordered_json report{{"format", "gustlab-bench/1"},
                                        {"minimal_step_ns", speed.minimal_step_ns},
                                        {"stock_step_ns", speed.stock_step_ns},
                                        {"loop_step_ns", speed.loop_step_ns},
                                        {"loop_over_minimal", over_minimal},
                                        {"loop_over_stock", over_stock},
                                        {"loop_steps_per_s", 1e9 / speed.loop_step_ns},
                                        {"two_threads_factor", speed.two_threads_factor}};
    fmt::print("{}\n", report.dump(2));
    return;
  }
  fmt::print("| step | time [ns] | over minimal |\n|---|--:|--:|\n");
  fmt::print("| mj_step of a minimal model | {:.0f} | 1.00 |\n", speed.minimal_step_ns);
  fmt::print("| mj_step of a stock model | {:.0f} | {:.2f} |\n", speed.stock_step_ns, speed.stock_step_ns / speed.minimal_step_ns);
  fmt::print("| closed loop: PID, gust, motor lag, metrics | {:.0f} | {:.2f} |\n", speed.loop_step_ns, over_minimal);
  fmt::print("\n{:.2f} M steps/s on one thread; two threads fly {:.2f} × as many flights.\n", 1e3 / speed.loop_step_ns, speed.two_threads_factor);
}

}  // namespace

void add_bench(CLI::App& app) {
  struct Options {
    std::string format = "md";
    int rounds = 15;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("bench", "measures the closed loop against a bare MuJoCo step");
  command->add_option("--format", options->format)->check(CLI::IsMember({"md", "json"}))->capture_default_str();
  command->add_option("--rounds", options->rounds, "the best of so many counts")->check(CLI::Range(1, 1000))->capture_default_str();
  command->callback([options] { bench(options->format, options->rounds); });
}

}  // namespace gustlab
