#include "report/score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "gustlab/errors.hpp"
#include "metrics/statistics.hpp"
#include "report/score_figures.hpp"

namespace gustlab {

namespace {

using Json = nlohmann::ordered_json;
using Trials = std::vector<ScoredTrial>;

template <class Wanted, class Good>
Json rate_of(const Trials& trials, Wanted wanted, Good good) {
  std::size_t k = 0, n = 0;
  for (const ScoredTrial& trial : trials)
    if (wanted(trial)) ++n, k += good(trial) ? 1 : 0;
  return score_rate(k, n);
}

Json headline(const Trials& trials) {
  const auto silent = [](const ScoredTrial& t) { return t.diagnosed && t.named.empty(); };
  const auto exact = [](const ScoredTrial& t) { return t.exact(); };
  const auto strict = [](const ScoredTrial& t) { return t.exact_strict(); };
  const auto all_found = [](const ScoredTrial& t) { return t.found() == static_cast<int>(t.truth.size()); };
  const auto single = [](std::size_t effects, bool above) {
    return [=](const ScoredTrial& t) { return !t.outside() && t.truth.size() == effects && t.above_limit() == above; };
  };
  const auto kind = [](const char* name) { return [=](const ScoredTrial& t) { return t.kind == name; }; };
  // below its limit an effect may stay unnamed; a wrong name is wrong at any strength
  const auto no_wrong_name = [](const ScoredTrial& t) {
    return t.diagnosed && std::all_of(t.right.begin(), t.right.end(), [](bool right) { return right; });
  };
  const auto located = [](const ScoredTrial& t) {
    return t.diagnosed && std::any_of(t.channels.begin(), t.channels.end(), [&](const std::string& channel) {
             return std::find(t.significant.begin(), t.significant.end(), channel) != t.significant.end();
           });
  };

  Json table;
  table["nothing concealed: no name"] = rate_of(trials, kind("clean"), silent);
  table["calibration scatter: no name"] = rate_of(trials, kind("scatter"), silent);
  table["one effect: exact"] = rate_of(trials, single(1, true), exact);
  table["one effect: exact, the name itself"] = rate_of(trials, single(1, true), strict);
  table["one effect below its limit: no wrong name"] = rate_of(trials, single(1, false), no_wrong_name);
  table["two effects: both among the names"] = rate_of(trials, single(2, true), all_found);
  table["two effects: exact"] = rate_of(trials, single(2, true), exact);
  table["two effects, one below its limit: no wrong name"] = rate_of(trials, single(2, false), no_wrong_name);
  // a wrong name is worse than none, and a right one withheld is a failure too
  std::size_t unnamed = 0, suspected = 0, names = 0, wrong = 0;
  for (const ScoredTrial& t : trials) {
    if (t.outside()) continue;
    names += t.named.size();
    wrong += static_cast<std::size_t>(std::count(t.right.begin(), t.right.end(), false));
    for (std::size_t i = 0; i < t.truth.size(); ++i)
      if (t.truth[i].above_limit() && t.partner[i] < 0) ++unnamed, suspected += t.suspects(t.truth[i]) ? 1 : 0;
  }
  table["effects without a name: suspected"] = score_rate(suspected, unnamed);
  table["names of what is not there"] = score_rate(wrong, names);
  table["outside the catalogue: no name"] = rate_of(trials, kind("outside"), silent);
  const auto visible = [](const ScoredTrial& t) {
    return t.outside() && !t.channels.empty() && !(t.stranger_strength < 1.0);
  };
  table["outside the catalogue, visible: channel located"] = rate_of(trials, visible, located);
  // a diagnosis that suspected every channel would always locate the right one
  std::size_t said = 0, right = 0;
  for (const ScoredTrial& t : trials) {
    if (!visible(t)) continue;
    for (const std::string& channel : t.significant) {
      ++said;
      right += std::count(t.channels.begin(), t.channels.end(), channel) > 0 ? 1 : 0;
    }
  }
  table["outside the catalogue, visible: channels said that are right"] = score_rate(right, said);
  return table;
}

Json per_effect(const Trials& trials) {
  struct Count {
    std::size_t hidden = 0, found = 0, named = 0, right = 0;
  };
  std::map<std::string, Count> counts;
  for (const ScoredTrial& trial : trials) {
    for (std::size_t i = 0; i < trial.truth.size() && !trial.outside(); ++i) {
      if (!trial.truth[i].above_limit()) continue;
      Count& count = counts[trial.truth[i].effect];
      ++count.hidden;
      if (trial.partner[i] >= 0) ++count.found;
    }
    // a right name counts for the truth that it stands for, a wrong one for itself
    for (std::size_t n = 0; n < trial.named.size(); ++n) {
      std::string label = trial.named[n].effect;
      for (std::size_t i = 0; i < trial.truth.size(); ++i)
        if (trial.partner[i] == static_cast<int>(n)) label = trial.truth[i].effect;
      ++counts[label].named;
      if (trial.right[n]) ++counts[label].right;
    }
  }
  Json table = Json::array();
  for (const auto& [effect, count] : counts)
    table.push_back({{"effect", effect},
                     {"recall", score_rate(count.found, count.hidden)},
                     {"precision", score_rate(count.right, count.named)}});
  return table;
}

// rows: what was concealed; columns: what was named for it
Json confusion(const Trials& trials) {
  std::map<std::string, std::map<std::string, int>> cells;
  std::set<std::string> columns;
  const auto add = [&](const std::string& row, const std::string& column) {
    ++cells[row][column];
    columns.insert(column);
  };
  for (const ScoredTrial& trial : trials) {
    std::vector<std::string> wrong;
    for (std::size_t n = 0; n < trial.named.size(); ++n)
      if (!trial.right[n]) wrong.push_back(trial.named[n].effect);
    const std::string none = trial.diagnosed ? "(nothing)" : "(no diagnosis)";
    if (trial.truth.empty() || trial.outside()) {
      const std::string row = fmt::format("({})", trial.outside() ? "outside" : trial.kind);
      if (wrong.empty()) add(row, none);
      for (const std::string& name : wrong) add(row, name);
      continue;
    }
    // an unnamed truth is confused with the wrong names of its trial, in their order; what is left over is extra
    auto next = wrong.begin();
    for (std::size_t i = 0; i < trial.truth.size(); ++i) {
      const Concealed& truth = trial.truth[i];
      const std::string row = truth.effect + (truth.above_limit() ? "" : " (below limit)");
      if (trial.partner[i] >= 0) add(row, truth.effect);
      else add(row, next != wrong.end() ? *next++ : none);
    }
    for (; next != wrong.end(); ++next) add("(one name too many)", *next);
  }
  Json rows = Json::object();
  for (const auto& [row, named] : cells) rows[row] = named;
  return {{"named", columns}, {"concealed", rows}};
}

Json verdicts(const Trials& trials) {
  std::map<std::string, std::map<std::string, int>> cells;
  for (const ScoredTrial& trial : trials) ++cells[trial.kind][trial.diagnosed ? trial.verdict : "(no diagnosis)"];
  Json table = Json::object();
  for (const auto& [kind, counts] : cells) table[kind] = counts;
  return table;
}

bool is_right(const ScoredTrial& trial) {
  if (!trial.diagnosed) return false;
  if (trial.outside()) return trial.named.empty();
  if (trial.above_limit()) return trial.exact();
  return std::all_of(trial.right.begin(), trial.right.end(), [](bool right) { return right; });
}

Json not_right(const Trials& trials) {
  Json list = Json::array();
  for (const ScoredTrial& trial : trials) {
    if (is_right(trial)) continue;
    Json truth = Json::array(), named = Json::array();
    const auto add = [&truth](const std::string& label, double strength) {
      truth.push_back(
          {{"effect", label}, {"strength_over_limit", std::isfinite(strength) ? Json(strength) : Json(nullptr)}});
    };
    for (const Concealed& hidden : trial.truth) add(hidden.label(), hidden.strength);
    if (!trial.stranger.empty()) add(trial.stranger, trial.stranger_strength);
    for (const Named& name : trial.named)
      named.push_back({{"effect", name.label()}, {"class", name.alternatives}, {"confidence", name.confidence}});
    list.push_back({{"set", trial.set},
                    {"trial", trial.trial},
                    {"kind", trial.kind},
                    {"verdict", trial.diagnosed || !trial.verdict.empty() ? trial.verdict : "missing"},
                    {"concealed", truth},
                    {"named", named}});
  }
  return list;
}

// what cannot be scored alone has not the form of a diagnosis, or of an answer
void check_figures(const ScoredTrial& trial, const TrialSet& set) {
  try {
    score_closure({trial});
    score_parameters({trial});
  } catch (const Json::exception&) {
    throw DataError(
        fmt::format("{}: the diagnosis of {} in {} and its answer do not fit together (values of \"parameters\" or "
                    "errors of \"fit\" and \"oracle\" have another form); diagnose it again, or repair the answer",
                    trial.where, trial.trial, set.folder));
  }
}

// a diagnosis that counted twice would make every interval too narrow
void check_stands_once(const ScoredTrial& trial, const TrialSet& set, std::map<std::string, std::string>& places) {
  const std::filesystem::path folder = std::filesystem::weakly_canonical(set.folder) / trial.trial / "";
  if (const auto [first, is_new] = places.emplace(folder.lexically_normal().string(), trial.where); !is_new)
    throw DataError(fmt::format("{}: trial \"{}\" stands twice (first at {}); leave one out", trial.where, trial.trial,
                                first->second));
}

}  // namespace

nlohmann::ordered_json score_trials(const std::vector<TrialSet>& sets, const std::string& diagnosis_folder) {
  Trials trials;
  std::map<std::string, std::string> places;
  for (const TrialSet& set : sets)
    for (ScoredTrial& trial : read_trials(set, diagnosis_folder)) {
      check_stands_once(trial, set, places);
      check_figures(trial, set);
      trials.push_back(std::move(trial));
    }
  const auto missing = std::count_if(trials.begin(), trials.end(), [](const ScoredTrial& t) { return !t.diagnosed; });
  Json score;
  score["format"] = "gustlab-score/1";
  score["trials"] = trials.size();
  score["without_diagnosis"] = missing;
  score["headline"] = headline(trials);
  score["effects"] = per_effect(trials);
  score["power"] = score_power(trials);
  score["parameters"] = score_parameters(trials);
  score["reliability"] = score_reliability(trials);
  score["closure"] = score_closure(trials);
  score["confusion"] = confusion(trials);
  score["verdicts"] = verdicts(trials);
  score["not_right"] = not_right(trials);
  return score;
}

}  // namespace gustlab
