// One function per command: declares it, its options and what it does. main() catches what they throw.
#pragma once

#include <CLI/CLI.hpp>

namespace gustlab {

// Thrown by a command that ends well but says something by its exit code.
struct ExitCode {
  int code;
};

// --help of import, export, render or view; empty where the Python environment is not there.
std::string help_of_script(const std::string& command);

void add_bench(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_compare(CLI::App& app);
void add_completion(CLI::App& app);
void add_conceal(CLI::App& app);
void add_defaults(CLI::App& app);
void add_diagnose(CLI::App& app);
void add_gate(CLI::App& app);
void add_identify(CLI::App& app);
void add_list(CLI::App& app);
void add_merge(CLI::App& app);
void add_metrics(CLI::App& app);
void add_replay(CLI::App& app);
void add_reproduce(CLI::App& app);
void add_run(CLI::App& app);
void add_score(CLI::App& app);
void add_scripts(CLI::App& app);  // import, export, render, view
void add_sweep(CLI::App& app);
void add_table(CLI::App& app);
void add_train(CLI::App& app);
void add_tune(CLI::App& app);
void add_vehicle(CLI::App& app);

}  // namespace gustlab
