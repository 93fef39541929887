#include "report/score_trial.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "gustlab/errors.hpp"
#include "gustlab/types.hpp"
#include "util/files.hpp"

namespace gustlab {

namespace {

using Json = nlohmann::ordered_json;

// destroying, copying and printing JSON goes as deep as the text does
constexpr int deepest = 100;
Json parse(const std::string& text) {
  return Json::parse(text, [](int depth, Json::parse_event_t, const Json&) {
    if (depth > deepest) throw Json::other_error::create(500, fmt::format("nested deeper than {}", deepest), nullptr);
    return true;
  });
}

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

Json part(const Json& object, const char* key) { return object.contains(key) ? object.at(key) : Json::object(); }

std::vector<std::string> texts(const Json& object, const char* key) {
  std::vector<std::string> found;
  if (object.contains(key))
    for (const Json& item : object.at(key)) found.push_back(item.get<std::string>());
  return found;
}

// of a number that may be any
int read_rotor(const Json& value) {
  const double number = value.get<double>();
  if (!(std::abs(number) <= max_rotors))
    throw Json::other_error::create(500, fmt::format("there is no rotor {}", number), nullptr);
  return static_cast<int>(number);
}

Concealed read_concealed(const Json& entry) {
  Concealed truth;
  truth.effect = entry.at("effect").get<std::string>();
  truth.parameters = part(entry, "parameters");
  truth.per_flight = part(entry, "per_flight");
  if (truth.parameters.contains("rotor")) truth.rotor = read_rotor(truth.parameters.at("rotor"));
  truth.parameters.erase("rotor");
  truth.strength = entry.value("strength_over_limit", std::numeric_limits<double>::quiet_NaN());
  return truth;
}

Named read_named(const Json& entry) {
  Named name;
  std::tie(name.effect, name.rotor) = split_label(entry.at("effect").get<std::string>());
  name.parameters = part(entry, "parameters");
  name.per_flight = part(entry, "per_flight");
  if (name.parameters.contains("rotor")) {
    const Json& rotor = name.parameters.at("rotor");
    name.rotor = read_rotor(rotor.is_object() ? rotor.at("value") : rotor);
    name.parameters.erase("rotor");
  }
  name.alternatives = texts(entry, "class");
  name.confidence = entry.value("confidence", 0.0);
  return name;
}

void read_diagnosis(const std::filesystem::path& path, ScoredTrial& trial) {
  std::string text;
  if (!read_into(path.string(), text).empty()) return;
  try {
    const Json diagnosis = parse(text);
    trial.verdict = diagnosis.at("verdict").get<std::string>();
    for (const Json& entry : diagnosis.at("effects")) trial.named.push_back(read_named(entry));
    for (const Json& entry : part(diagnosis, "suspected")) trial.suspected.push_back(read_named(entry));
    for (const Json& entry : part(diagnosis, "mismatch"))
      if (entry.value("significant", false)) trial.significant.push_back(entry.at("channel").get<std::string>());
    trial.fit = part(diagnosis, "fit");
    trial.diagnosed = true;
  } catch (const Json::exception& e) {
    spdlog::warn("{}: is no diagnosis ({}); it counts as missing", path.string(), e.what());
    trial.verdict = "unreadable";
    trial.named.clear();
    trial.suspected.clear();
    trial.significant.clear();
  }
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
  if (!std::filesystem::is_directory(set.folder))
    throw DataError(fmt::format("{}: no such folder (the trials of {} are in it)", set.folder, set.answers));
  std::vector<ScoredTrial> trials;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    ScoredTrial trial;
    try {
      const Json answer = parse(line);
      trial.set = std::filesystem::path(set.folder).lexically_normal().filename().string();
      trial.trial = answer.at("trial").get<std::string>();
      for (const Json& entry : answer.at("effects")) trial.truth.push_back(read_concealed(entry));
      const char* kinds[] = {"clean", "single", "pair"};
      trial.kind = answer.value("kind", std::string(kinds[std::min<std::size_t>(2, trial.truth.size())]));
      trial.vehicle = answer.value("vehicle", std::string());
      const Json stranger = part(answer, "outside");
      trial.stranger = stranger.value("name", std::string());
      trial.stranger_strength = stranger.value("strength_over_limit", std::numeric_limits<double>::quiet_NaN());
      trial.channels = texts(stranger, "channels");
      trial.oracle = part(answer, "oracle");
    } catch (const Json::exception& error) {
      throw DataError(fmt::format("{}:{}:1: not an answer ({}); expected an object with trial, kind and effects",
                                  set.answers, number, error.what()));
    }
    read_diagnosis(std::filesystem::path(set.folder) / trial.trial / diagnosis_folder / "diagnosis.json", trial);
    assign(trial);
    trials.push_back(std::move(trial));
  }
  if (trials.empty()) throw DataError(fmt::format("{}: no answers (each is one line of JSON)", set.answers));
  return trials;
}

}  // namespace gustlab
