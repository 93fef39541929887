// One function per command: declares it, its options and what it does. main() catches what they throw.
#pragma once

#include <CLI/CLI.hpp>

namespace gustlab {

void add_defaults(CLI::App& app);
void add_diagnose(CLI::App& app);
void add_identify(CLI::App& app);
void add_list(CLI::App& app);
void add_replay(CLI::App& app);
void add_score(CLI::App& app);

}  // namespace gustlab
