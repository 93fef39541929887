// TOML with positions: every value knows file:line:col, every key must be known.
//
// Messages: `file:line:col: problem (why); suggestion`, thrown as ConfigError (or DataError for sidecars of recordings).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gustlab/errors.hpp"
#include "gustlab/parameters.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab::config {

// A table being read. Keys are taken one by one; finish() throws for the first key that nobody took, with the nearest
// known name as suggestion. Copies share what was taken.
class Table {
 public:
  // Parses a file; `overrides` are --set key=value pairs with dotted keys, their position is the command line.
  static Table read_file(const std::string& path, const std::vector<std::string>& overrides = {});
  static Table parse(std::string_view text, const std::string& path, const std::vector<std::string>& overrides = {});
  // The parameters of an effect as a table again, each where it was written.
  static Table of_effect(const EffectSpec& spec);

  bool has(std::string_view key) const;
  std::string where(std::string_view key = {}) const;  // file:line:col of a key, or of the table
  const std::string& path() const;
  std::vector<std::string> keys() const;  // in file order

  // std::nullopt when absent; ConfigError on a wrong type. number() also takes an integer.
  std::optional<double> number(std::string_view key);
  std::optional<std::int64_t> integer(std::string_view key);
  std::optional<bool> flag(std::string_view key);
  std::optional<std::string> text(std::string_view key);
  std::optional<std::vector<double>> numbers(std::string_view key);
  // an override may also say them as a,b,c
  std::optional<std::vector<std::string>> texts(std::string_view key);
  std::optional<std::vector<std::vector<double>>> number_rows(std::string_view key);  // [[1, 2], [3, 4]]
  std::optional<Table> table(std::string_view key);
  std::vector<Table> tables(std::string_view key);  // array of tables; empty when absent
  // the value as a TOML literal, whatever it is
  std::optional<std::string> literal(std::string_view key);
  // of an array, entry by entry
  std::optional<std::vector<std::string>> literals(std::string_view key);

  // as above, with a message when absent
  double need_number(std::string_view key);
  std::string need_text(std::string_view key);
  std::vector<std::string> need_texts(std::string_view key);

  // Throws ConfigError at a key: where(key): problem (why); suggestion.
  [[noreturn]] void fail(std::string_view key, const std::string& problem, const std::string& why,
                         const std::string& suggestion) const;
  // What is to be said of each key of this table, and of those tables in it that were asked for, that nobody asked for.
  std::vector<std::string> unknown_keys() const;
  // Throws ConfigError for the first of them.
  void finish() const;

 private:
  struct Node;
  std::shared_ptr<Node> node_;
};

// All that is wrong with a file, for one message.
class Problems {
 public:
  // Runs `read`, and keeps what it throws.
  template <class Read>
  void collect(Read read) {
    try {
      read();
    } catch (const ConfigError& error) {
      add(error.what());
    }
  }
  // Keeps a message, once; an empty one is none.
  void add(const std::string& message);
  // Throws ConfigError when there are some, a line for each.
  void raise() const;

 private:
  std::vector<std::string> messages_;
};

// Reads declared parameters from a table: types, ranges and unknown keys checked; absent keys keep their defaults.
void read_parameters(Table& table, Parameterized& target);
// Reads the parameters of an [[effect]] that a vehicle or an experiment carries as an EffectSpec.
void read_parameters(const EffectSpec& spec, Parameterized& target);
// file:line:col of a parameter, or of the table where that does not say it; empty when nobody wrote it.
std::string where(const EffectSpec& spec, std::string_view parameter);
// Runs `action`. What it says is wrong with a parameter is said with the place where that was written.
template <class Action>
auto at_place(const EffectSpec& spec, Action action) {
  try {
    return action();
  } catch (const ParameterError& error) {
    const std::string place = where(spec, error.parameter);
    if (place.empty()) throw;
    throw ConfigError(place + ": " + error.what());
  }
}
// One `name = value` per line, every parameter, shortest round-trip text: the part of a run key that it contributes.
std::string canonical_text(Parameterized& target);
// The same with units, ranges and help as comments: `gustlab defaults NAME`.
std::string commented_text(Parameterized& target);
// `[environment]` of a document; what is missing is not assumed.
Environment read_environment(Table& document);
// What a table says besides its type, to be read by read_parameters() later.
EffectSpec read_spec(Table& table, const std::string& type);
// `[[effect]]` tables of a document.
std::vector<EffectSpec> read_effects(Table& document);
// Later specs replace earlier ones of the same type; the same type twice in one list is an error (rotor_loss: same rotor).
std::vector<EffectSpec> merge_effects(const std::vector<EffectSpec>& base, const std::vector<EffectSpec>& over);

// The dotted keys that an override sets: `effect.gust={sigma_xy=1, on_s=2}` sets two. Throws ConfigError when it is none.
std::vector<std::string> override_keys(const std::string& override_text);

// The known name nearest to a mistyped one, as `did you mean "…"?`, or empty.
std::string suggest(std::string_view mistyped, const std::vector<std::string>& known);
// The shortest text that reads back as the same double.
std::string shortest(double value);

}  // namespace gustlab::config
