// Options that several commands share, spelled alike everywhere.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "simulation/experiment.hpp"

namespace gustlab {

// EXPERIMENT, --set and --seed.
struct ExperimentOptions {
  std::string experiment;
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;

  void add_to(CLI::App& command);
  Experiment read() const;
  // one experiment for each [[variant]] and point of its axes, or for each of `only`; without any, the experiment itself
  std::vector<Experiment> read_variants(const std::vector<std::string>& only = {}) const;
  // --set and --seed as overrides
  std::vector<std::string> overrides() const;
  // as a shell takes them, for files that say which command made them; of a path only the file's name
  std::string words() const;
};

// A word of a command line as a shell takes it, on one line.
std::string shell_word(const std::string& word);

// Checks of a number, which is finite: at least 0; above 0; from 0 to `most`.
CLI::Validator not_negative();
CLI::Validator positive();
CLI::Validator number_up_to(double most);
// Throws ConfigError for one of these options that is given though what was chosen ("optimizer sr3") does not read it: that is a
// misunderstanding. `readers`: what does read it.
void check_is_read(const CLI::App& command, std::initializer_list<const char*> names, bool read,
                   const std::string& chosen, const char* readers);
// Takes a path to those that were `seen`. Throws ConfigError where it is among them, whatever it is called there. `use`: "a flight is fitted
// once, or held out".
void check_is_new(const std::string& path, std::set<std::filesystem::path>& seen, const std::string& use);
// The same of all paths.
void check_paths_differ(const std::vector<std::string>& paths, const std::string& use);
// Throws ConfigError for a key that two --set say.
void check_set_once(const std::vector<std::string>& settings);
// --jobs.
void add_jobs(CLI::App& command, int& jobs);

}  // namespace gustlab
