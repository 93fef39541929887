// One concealed trial: what was hidden, what the diagnosis named, and which name belongs to which truth.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gustlab {

struct TrialSet {
  std::string answers;  // JSON lines: trial, kind, vehicle, effects
  std::string folder;   // <folder>/<trial>/<diagnosis>/diagnosis.json
};

struct Concealed {
  std::string effect;
  int rotor = 0;          // rotor_loss: 1…N
  double strength = 0.0;  // over its detection limit; NaN when the answers do not say
  nlohmann::ordered_json parameters, per_flight;
  bool above_limit() const { return !(strength < 1.0); }
  std::string label() const;
};

struct Named {
  std::string effect;
  int rotor = 0;
  std::vector<std::string> alternatives;  // the class: every name that the data cannot tell from this one
  double confidence = 0.0;
  nlohmann::ordered_json parameters, per_flight;
  std::string label() const;
};

struct ScoredTrial {
  std::string set, trial, kind, vehicle;
  std::string where;  // file:line:col of its answer
  std::vector<Concealed> truth;
  bool diagnosed = false;  // false: no readable diagnosis.json, which counts as a failure everywhere
  std::string verdict;
  std::vector<Named> named;
  std::vector<int> partner;      // of each truth: index into named, or −1
  std::vector<bool> right;       // of each name: it belongs to a truth
  std::vector<Named> suspected;  // said with its probability, not named
  // physics outside the catalogue: what it is, how visible (like strength above), and where it acts
  std::string stranger;
  double stranger_strength = 0.0;
  std::vector<std::string> channels;
  std::vector<std::string> significant;  // channels that the diagnosis reports
  nlohmann::ordered_json fit, oracle;

  bool outside() const { return kind == "outside"; }
  bool above_limit() const;  // every concealed effect
  int found() const;         // how many truths have a name
  bool suspects(const Concealed& truth) const;
  bool exact() const;         // every truth has a name and every name a truth
  bool exact_strict() const;  // likewise, with the name itself and not one of its class
};

// A name matches a truth when the truth is the name or in its class; for rotor_loss the rotor must agree too.
bool matches(const Named& name, const Concealed& truth);

// Reads every answer of a set and the diagnosis beside it. DataError with file:line:col for answers that cannot be read.
std::vector<ScoredTrial> read_trials(const TrialSet& set, const std::string& diagnosis_folder);

}  // namespace gustlab
