#include "options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "gustlab/errors.hpp"
#include "simulation/variants.hpp"

namespace gustlab {

void ExperimentOptions::add_to(CLI::App& command) {
  command.add_option("EXPERIMENT", experiment, "a TOML file, or its name under experiments/")->required();
  command.add_option("--set", set, "changes a key of the experiment: key=value with a dotted key, any number of them")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  command.add_option("--seed", seed, "of every random stream, instead of the experiment's")
      ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()).description(""))
      ->check(CLI::Validator(
          // what is larger is clipped before the range is looked at
          [](const std::string& word) {
            return word.size() > 19 ? "Value " + word + " not in range 0 to 9223372036854775807" : std::string();
          },
          ""));
}

std::vector<std::string> ExperimentOptions::overrides() const {
  check_set_once(set);
  for (const std::string& setting : set)
    if (seed && !key_of_both(setting, "seed=0").empty())
      throw ConfigError(fmt::format("--set {}: seed is set twice (--seed says it, too); leave one out", setting));
  std::vector<std::string> all = set;
  if (seed) all.push_back("seed=" + std::to_string(*seed));
  return all;
}

Experiment ExperimentOptions::read() const { return read_experiment(find_experiment(experiment), overrides()); }

std::vector<Experiment> ExperimentOptions::read_variants(const std::vector<std::string>& only) const {
  return gustlab::read_variants(find_experiment(experiment), overrides(), only);
}

std::string ExperimentOptions::words() const {
  std::string text = shell_word(std::filesystem::path(experiment).filename().string());
  for (const std::string& setting : set) text += " --set " + shell_word(setting);
  return seed ? fmt::format("{} --seed {}", text, *seed) : text;
}

std::string shell_word(const std::string& word) {
  constexpr std::string_view plain = "_-./=,:+@%";
  const auto is_plain = [&](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || plain.find(c) < plain.size();
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  // only $'…' can hold everything on one line
  std::string text = "$'";
  for (const char c : word)
    if (const auto code = static_cast<unsigned char>(c); code < 32 || code == 127)
      text += fmt::format("\\x{:02x}", code);
    else text += fmt::format("{}{}", c == '\'' || c == '\\' ? "\\" : "", c);
  text += "'";
  return text.find('\\') == std::string::npos ? text.substr(1) : text;
}

namespace {

// NaN and infinity are of no use to any option, and CLI11's own checks let them pass
CLI::Validator finite(const std::string& range, const std::function<bool(double)>& holds) {
  return CLI::Validator(
      [range, holds](std::string& text) {
        double value = 0.0;
        const bool good = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && holds(value);
        return good ? std::string() : text + " is not a number " + range;
      },
      range);
}

}  // namespace

CLI::Validator not_negative() {
  return finite("from 0 up", [](double value) { return value >= 0.0; });
}

CLI::Validator positive() {
  return finite("above 0", [](double value) { return value > 0.0; });
}

CLI::Validator number_up_to(double most) {
  return finite(fmt::format("from 0 to {}", most), [most](double value) { return value >= 0.0 && value <= most; });
}

void check_is_read(const CLI::App& command, std::initializer_list<const char*> names, bool read,
                   const std::string& chosen, const char* readers) {
  for (const char* name : names)
    if (!read && command.count(name) > 0)
      throw ConfigError(fmt::format("{}: {} has no use for it (it is for {}); leave it out", name, chosen, readers));
}

void check_set_once(const std::vector<std::string>& settings) {
  if (const auto twice = set_twice(settings))
    throw ConfigError(fmt::format("--set {}: {} is set twice (--set {} would be lost); leave one out", twice->second,
                                  twice->key, twice->first));
}

void check_is_new(const std::string& path, std::set<std::filesystem::path>& seen, const std::string& use) {
  std::error_code wrong;  // whoever reads it says what
  const std::filesystem::path whole = std::filesystem::weakly_canonical(path, wrong);
  if (!seen.insert(wrong ? std::filesystem::path(path) : whole).second)
    throw ConfigError(fmt::format("{}: is given twice ({}); leave one out", path, use));
}

void check_paths_differ(const std::vector<std::string>& paths, const std::string& use) {
  std::set<std::filesystem::path> seen;
  for (const std::string& path : paths) check_is_new(path, seen, use);
}

void add_jobs(CLI::App& command, int& jobs) {
  command.add_option("-j,--jobs", jobs, "threads; the results are the same for any number")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
}

}  // namespace gustlab
