#include "report/score_trial.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "config/text.hpp"
#include "config/toml.hpp"
#include "flight_log/trial_kinds.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/types.hpp"
#include "report/json_part.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

using Json = nlohmann::ordered_json;

// rotor_loss#3 is the loss of rotor 3
std::pair<std::string, int> split_label(const std::string& label) {
  const std::size_t mark = label.find('#');
  if (mark == std::string::npos) return {label, 0};
  int rotor = 0;
  std::from_chars(label.data() + mark + 1, label.data() + label.size(), rotor);  // too large a number leaves 0
  return {label.substr(0, mark), rotor};
}

std::string make_label(const std::string& effect, int rotor) {
  return rotor > 0 ? fmt::format("{}#{}", effect, rotor) : effect;
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

int read_rotor(const JsonPart& value) {
  const double number = value.number();
  if (!(std::abs(number) <= max_rotors)) value.fail(fmt::format("there is no rotor {}", number));
  return static_cast<int>(number);
}

// one of some words
std::string read_one_of(const JsonPart& value, const char* what, const std::vector<std::string>& known) {
  const std::string word = value.text();
  if (std::find(known.begin(), known.end(), word) == known.end())
    value.fail(fmt::format("\"{}\" is no {}", config::printable(word), what),
               worded("use one of " + fmt::format("{}", fmt::join(known, ", ")), "", config::suggest(word, known)));
  return word;
}

Concealed read_concealed(const JsonPart& entry, bool in_catalogue) {
  Concealed truth;
  const JsonPart effect = entry.need("effect");
  truth.effect = effect.text();
  if (in_catalogue) {
    std::vector<std::string> known;
    for (const EffectRow& row : effect_registry()) known.emplace_back(row.name);
    read_one_of(effect, "effect", known);
  }
  if (const auto parameters = entry.find("parameters")) {
    for (const JsonPart& value : parameters->members())
      if (in_catalogue) value.number();
    if (const auto rotor = parameters->find("rotor")) truth.rotor = read_rotor(*rotor);
  }
  if (const auto flights = entry.find("per_flight"))
    for (const JsonPart& flight : flights->members())
      for (const JsonPart& value : flight.members()) value.number();
  truth.parameters = entry.copy("parameters");
  truth.parameters.erase("rotor");
  truth.per_flight = entry.copy("per_flight");
  truth.strength = entry.number("strength_over_limit", unknown);
  return truth;
}

Named read_named(const JsonPart& entry) {
  Named name;
  std::tie(name.effect, name.rotor) = split_label(entry.need("effect").text());
  name.parameters = entry.copy("parameters");
  name.per_flight = entry.copy("per_flight");
  if (const auto parameters = entry.find("parameters"))
    if (const auto rotor = parameters->find("rotor")) {
      name.rotor = read_rotor(rotor->is_object() ? rotor->need("value") : *rotor);
      name.parameters.erase("rotor");
    }
  name.alternatives = entry.texts("class");
  name.confidence = entry.number("confidence", 0.0);
  return name;
}

void read_diagnosis(const std::filesystem::path& path, ScoredTrial& trial) {
  std::string text;
  if (!read_into(path.string(), text).empty()) return;
  try {
    const Json whole = parse_json(text);
    const JsonPart diagnosis(text, whole);
    trial.verdict = diagnosis.need("verdict").text();
    for (const JsonPart& entry : diagnosis.need("effects").items()) trial.named.push_back(read_named(entry));
    for (const JsonPart& entry : diagnosis.items("suspected")) trial.suspected.push_back(read_named(entry));
    for (const JsonPart& entry : diagnosis.items("mismatch"))
      if (entry.flag("significant", false)) trial.significant.push_back(entry.need("channel").text());
    trial.fit = diagnosis.copy("fit");
    trial.diagnosed = true;
  } catch (const JsonFault& fault) {
    spdlog::warn("{}:{}: is no diagnosis ({}); it counts as missing", path.string(), json_place(text, fault.offset),
                 fault.what());
    trial.verdict = "unreadable";
    trial.named.clear();
    trial.suspected.clear();
    trial.significant.clear();
  }
}

// a name, or a path, below the folder of the trials
std::string read_trial_name(const JsonPart& value) {
  const std::filesystem::path inside = std::filesystem::path(value.text()).lexically_normal();
  if (inside.empty() || inside.is_absolute() || inside == "." || *inside.begin() == "..")
    value.fail(fmt::format("\"{}\" is no folder below that of the trials", config::printable(value.text())));
  return value.text();
}

void read_answer(const JsonPart& answer, ScoredTrial& trial) {
  trial.trial = read_trial_name(answer.need("trial"));
  const JsonPart effects = answer.need("effects");
  const auto kind = answer.find("kind");
  trial.kind = kind ? read_one_of(*kind, "kind of trial", trial_kinds()) : trial_kind_of(effects.items().size());
  if (trial.kind == "nothing") trial.kind = "clean";
  for (const JsonPart& entry : effects.items()) trial.truth.push_back(read_concealed(entry, !trial.outside()));
  trial.vehicle = answer.text("vehicle", "");
  if (const auto stranger = answer.find("outside")) {
    trial.stranger = stranger->text("name", "");
    trial.stranger_strength = stranger->number("strength_over_limit", unknown);
    trial.channels = stranger->texts("channels");
  } else {
    trial.stranger_strength = unknown;
  }
  trial.oracle = answer.copy("oracle");
}

// the assignment of names to truths that leaves the fewest truths alone, names themselves before their classes
struct Assignment {
  const ScoredTrial& trial;
  std::vector<int> current, best;
  std::vector<bool> taken;
  int best_score = -1;

  void search(std::size_t i, int score) {
    if (i == trial.truth.size()) {
      if (score > best_score) best_score = score, best = current;
      return;
    }
    for (std::size_t n = 0; n < trial.named.size(); ++n) {
      if (taken[n] || !matches(trial.named[n], trial.truth[i])) continue;
      taken[n] = true;
      current[i] = static_cast<int>(n);
      search(i + 1, score + (trial.named[n].effect == trial.truth[i].effect ? 101 : 100));
      taken[n] = false;
    }
    current[i] = -1;
    search(i + 1, score);
  }
};

void assign(ScoredTrial& trial) {
  Assignment assignment{trial, std::vector<int>(trial.truth.size(), -1), {}, std::vector<bool>(trial.named.size()), -1};
  assignment.search(0, 0);
  trial.partner = assignment.best;
  trial.right.assign(trial.named.size(), false);
  for (const int name : trial.partner)
    if (name >= 0) trial.right[static_cast<std::size_t>(name)] = true;
}

}  // namespace

std::string Concealed::label() const { return make_label(effect, rotor); }
std::string Named::label() const { return make_label(effect, rotor); }

bool ScoredTrial::above_limit() const {
  return std::all_of(truth.begin(), truth.end(), [](const Concealed& t) { return t.above_limit(); });
}

int ScoredTrial::found() const {
  return static_cast<int>(std::count_if(partner.begin(), partner.end(), [](int name) { return name >= 0; }));
}

bool ScoredTrial::suspects(const Concealed& effect) const {
  return std::any_of(suspected.begin(), suspected.end(), [&](const Named& name) { return matches(name, effect); });
}

bool ScoredTrial::exact() const {
  return diagnosed && named.size() == truth.size() && found() == static_cast<int>(truth.size());
}

bool ScoredTrial::exact_strict() const {
  if (!exact()) return false;
  for (std::size_t i = 0; i < truth.size(); ++i)
    if (named[static_cast<std::size_t>(partner[i])].effect != truth[i].effect) return false;
  return true;
}

bool matches(const Named& name, const Concealed& truth) {
  if (name.effect == truth.effect) return truth.rotor == 0 || name.rotor == truth.rotor;
  return std::any_of(name.alternatives.begin(), name.alternatives.end(), [&](const std::string& label) {
    const auto [effect, rotor] = split_label(label);
    return effect == truth.effect && (rotor == 0 || rotor == truth.rotor);
  });
}

std::vector<ScoredTrial> read_trials(const TrialSet& set, const std::string& diagnosis_folder) {
  std::istringstream file(read_file<DataError>(set.answers));
  check_input_path(set.folder);
  if (!std::filesystem::is_directory(set.folder))
    throw DataError(fmt::format("{}: no such folder (the trials of {} are in it)", set.folder, set.answers));
  std::vector<ScoredTrial> trials;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    ScoredTrial trial;
    trial.set = std::filesystem::path(set.folder).lexically_normal().filename().string();
    try {
      const Json whole = parse_json(line);
      const JsonPart answer(line, whole);
      read_answer(answer, trial);
      trial.where = fmt::format("{}:{}", set.answers, json_place(line, answer.need("trial").offset(), number));
    } catch (const JsonFault& fault) {
      throw DataError(
          worded(fmt::format("{}:{}: not an answer", set.answers, json_place(line, fault.offset, number)), fault.what(),
                 fault.suggestion.empty() ? "expected an object with trial, kind and effects" : fault.suggestion));
    }
    read_diagnosis(std::filesystem::path(set.folder) / trial.trial / diagnosis_folder / "diagnosis.json", trial);
    assign(trial);
    trials.push_back(std::move(trial));
  }
  if (trials.empty()) throw DataError(fmt::format("{}: no answers (each is one line of JSON)", set.answers));
  return trials;
}

}  // namespace gustlab
