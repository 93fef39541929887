#include "report/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "config/json_text.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr double least_held = 0.95;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool holds(const ComparedController& controller) {
  return static_cast<double>(controller.held) >= least_held * static_cast<double>(controller.total);
}

// errors per controller, in one order of the runs; NaN where a run was not completed
struct Errors {
  std::vector<std::string> names, runs;
  std::vector<std::int64_t> gusts;  // of each run: its replicate
  std::vector<std::vector<double>> rmse_m, rotor_sd_radps, rotor_rate_radps2;
};
Errors errors_of(const Results& results) {
  Errors errors;
  std::vector<std::vector<std::string>> runs;
  for (const ResultRow& row : results.rows) {
    const auto at = static_cast<std::size_t>(std::find(errors.names.begin(), errors.names.end(), row.controller) -
                                             errors.names.begin());
    if (at == errors.names.size()) {
      errors.names.push_back(row.controller);
      for (auto* values : {&errors.rmse_m, &errors.rotor_sd_radps, &errors.rotor_rate_radps2}) values->emplace_back();
      runs.emplace_back();
    }
    const bool completed = row.outcome == Outcome::completed;
    errors.rmse_m[at].push_back(completed ? row.rmse_xy_m : nan);
    errors.rotor_sd_radps[at].push_back(completed ? row.rotor_sd_radps : nan);
    errors.rotor_rate_radps2[at].push_back(completed ? row.rotor_rate_radps2 : nan);
    runs[at].push_back(fmt::format("{} {}", row.trajectory, row.replicate));
    if (at == 0) errors.gusts.push_back(row.replicate);
  }
  for (const auto& other : runs)
    if (other != runs.front())
      throw DataError(results.rows.front().experiment +
                      ": its controllers did not fly the same runs (a comparison is paired)");
  if (!runs.empty()) errors.runs = runs.front();
  return errors;
}

// means over the trajectories that met a gust, one for each gust: what a bootstrap may resample. NaN where one was not completed.
std::vector<double> by_gust(const std::vector<double>& values, const std::vector<std::int64_t>& gusts) {
  std::map<std::int64_t, std::pair<double, double>> sums;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sums[gusts[i]].first += values[i];
    sums[gusts[i]].second += 1.0;
  }
  std::vector<double> means;
  for (const auto& [gust, sum] : sums) means.push_back(sum.first / sum.second);
  return means;
}

ComparedVariant compare_one(const std::string& name, const Errors& errors, double limit_m) {
  ComparedVariant variant{name, 0, {}};
  for (std::size_t c = 0; c < errors.names.size(); ++c) {
    ComparedController controller;
    const Summary summary = summarize(errors.rmse_m[c]);
    controller.name = errors.names[c];
    controller.completed = summary.n;
    controller.total = errors.runs.size();
    controller.held = static_cast<std::size_t>(std::count_if(errors.rmse_m[c].begin(), errors.rmse_m[c].end(),
                                                             [&](double rmse_m) { return rmse_m <= limit_m; }));
    controller.held_share = wilson_interval(controller.held, controller.total);
    controller.broken = !holds(controller);
    controller.rmse_m = summary.mean;
    controller.rotor_sd_radps = summarize(errors.rotor_sd_radps[c]).mean;
    controller.rotor_rate_radps2 = summarize(errors.rotor_rate_radps2[c]).mean;
    variant.controllers.push_back(controller);
  }
  const auto better = [](const ComparedController& a, const ComparedController& b) {
    if (holds(a) != holds(b)) return holds(a);
    if (!holds(a) && a.held != b.held) return a.held > b.held;
    return a.rmse_m < b.rmse_m;
  };
  variant.best = static_cast<std::size_t>(
      std::min_element(variant.controllers.begin(), variant.controllers.end(), better) - variant.controllers.begin());
  for (std::size_t c = 0; c < errors.names.size(); ++c) {
    ComparedController& controller = variant.controllers[c];
    controller.behind_m = paired_test(errors.rmse_m[c], errors.rmse_m[variant.best]).difference;
    // the same resamples for every pair
    controller.behind =
        paired_bootstrap(by_gust(errors.rmse_m[c], errors.gusts), by_gust(errors.rmse_m[variant.best], errors.gusts),
                         RandomStream(1, 0, "compare"));
    controller.as_good_as_best =
        controller.held > 0 && (c == variant.best || (holds(controller) == holds(variant.controllers[variant.best]) &&
                                                      controller.behind.low <= 0.0));
  }
  return variant;
}

std::string cell(const ComparedController& controller, bool best) {
  std::string text = std::isnan(controller.rmse_m) ? "–" : fmt::format("{:.3f}", controller.rmse_m);
  if (best) text = "**" + text + "**";
  if (controller.held < controller.total) text += fmt::format(" ({}/{})", controller.held, controller.total);
  if (controller.broken) text += " †";
  return text;
}

// nobody is best where nobody held a run
std::string variant_row(const ComparedVariant& variant) {
  const bool any = variant.controllers[variant.best].held > 0;
  std::vector<std::string> good{any ? variant.controllers[variant.best].name : "–"};
  std::string text = fmt::format("\n| {} |", variant.name);
  const ComparedController* next = nullptr;
  for (std::size_t c = 0; c < variant.controllers.size(); ++c) {
    const ComparedController& controller = variant.controllers[c];
    text += fmt::format(" {} |", cell(controller, any && c == variant.best));
    if (c == variant.best) continue;
    if (controller.as_good_as_best) good.push_back(controller.name);
    else if (holds(controller) && (next == nullptr || controller.behind_m < next->behind_m)) next = &controller;
  }
  text += fmt::format(" {} |", fmt::join(good, ", "));
  return text + (next == nullptr ? " – |"
                                 : fmt::format(" {}: {:.4f} [{:.4f}, {:.4f}] |", next->name, next->behind_m,
                                               next->behind.low, next->behind.high));
}

}  // namespace

std::vector<ComparedVariant> compare(std::span<const NamedResults> variants, double limit_m) {
  std::vector<ComparedVariant> compared;
  Errors first;
  for (const auto& [name, results, alone] : variants) {
    const Errors errors = errors_of(results);
    if (compared.empty()) first = errors;
    if (errors.names != first.names || errors.runs != first.runs)
      throw DataError(fmt::format("{} and {} do not have the same controllers and runs (a comparison is paired)",
                                  variants.front().name, name));
    if (results.settle_s != variants.front().results.settle_s)
      throw DataError(fmt::format("{} and {} settle for {} s and for {} s (no comparison has both); leave one out",
                                  variants.front().name, name, variants.front().results.settle_s, results.settle_s));
    compared.push_back(compare_one(name, errors, limit_m));
    compared.back().alone = alone;
    compared.back().settle_s = results.settle_s;
  }
  return compared;
}

std::vector<Margin> margins_of(std::span<const ComparedVariant> variants) {
  std::vector<Margin> margins;
  for (const ComparedVariant& variant : variants) {
    if (variant.alone.name.empty()) continue;
    if (margins.empty() || margins.back().axis != variant.alone.name)
      margins.push_back({variant.alone.name, {}, std::vector<std::size_t>(variant.controllers.size(), 0)});
    Margin& margin = margins.back();
    for (std::size_t c = 0; c < variant.controllers.size(); ++c)
      if (!variant.controllers[c].broken && margin.held[c] == margin.values.size()) ++margin.held[c];
    margin.values.push_back(variant.alone.value);
  }
  return margins;
}

std::string to_markdown(std::span<const ComparedVariant> variants, double limit_m) {
  const std::vector<ComparedController>& columns = variants.front().controllers;
  std::string text = "| variant |";
  for (const ComparedController& controller : columns) text += fmt::format(" {} |", controller.name);
  text += " best, or not told from it | ahead of the next by |\n|---|";
  for (std::size_t i = 0; i < columns.size(); ++i) text += "--:|";
  text += "---|--:|";
  for (const ComparedVariant& variant : variants) text += variant_row(variant);
  text += fmt::format(
      "\n\nMean planar RMSE in m, samples from {} s on, over the runs that were completed, of {} in each cell, the "
      "same gusts for all; held/all where a run was not held: a run is held when it reaches its end with a planar RMSE "
      "of at most {} m. In brackets the 95 % "
      "interval of the "
      "paired difference (bootstrap over gusts, each with all its trajectories). † broken: fewer than 95 % of the runs "
      "are held.\n\n"
      "| controller | rotor speeds in {}, rad/s | their rate, rad/s² | best in | breaks in |\n|---|--:|--:|---|---|\n",
      config::shortest(variants.front().settle_s), columns.front().total, config::shortest(limit_m),
      variants.front().name);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    std::vector<std::string> best, broken;
    for (const ComparedVariant& variant : variants) {
      if (variant.controllers[c].as_good_as_best) best.push_back(variant.name);
      if (variant.controllers[c].broken) broken.push_back(variant.name);
    }
    text += fmt::format("| {} | {:.0f} | {:.0f} | {} | {} |\n", columns[c].name, columns[c].rotor_sd_radps,
                        columns[c].rotor_rate_radps2, best.empty() ? "–" : fmt::format("{}", fmt::join(best, ", ")),
                        broken.empty() ? "–" : fmt::format("{}", fmt::join(broken, ", ")));
  }
  if (const std::vector<Margin> margins = margins_of(variants); !margins.empty()) {
    text += "\n| holds up to |";
    for (const ComparedController& controller : columns) text += fmt::format(" {} |", controller.name);
    text += " flown |\n|---|";
    for (std::size_t i = 0; i < columns.size(); ++i) text += "--:|";
    text += "---|";
    for (const Margin& margin : margins) {
      text += fmt::format("\n| {} |", margin.axis);
      for (const std::size_t held : margin.held)
        text += held == 0                      ? " – |"
                : held == margin.values.size() ? fmt::format(" ≥ {} |", margin.values.back())
                                               : fmt::format(" {} |", margin.values[held - 1]);
      text += fmt::format(" {} |", fmt::join(margin.values, ", "));
    }
    text += "\n\nThe last value before the first at which a controller is broken; – where that is the first flown.\n";
  }
  return text;
}

std::string to_json(std::span<const ComparedVariant> variants, double limit_m) {
  nlohmann::ordered_json json{{"format", "gustlab-comparison/2"},
                              {"limit_m", limit_m},
                              {"settle_s", variants.front().settle_s},
                              {"variants", nlohmann::ordered_json::array()}};
  const auto number = [](double value) {
    return std::isnan(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  };
  for (const ComparedVariant& variant : variants) {
    nlohmann::ordered_json entry{{"variant", variant.name}, {"best", nullptr}};
    if (const ComparedController& best = variant.controllers[variant.best]; best.held > 0) entry["best"] = best.name;
    for (const ComparedController& c : variant.controllers)
      entry["controllers"].push_back({{"controller", c.name},
                                      {"completed", c.completed},
                                      {"held", c.held},
                                      {"total", c.total},
                                      {"held_95", {c.held_share.low, c.held_share.high}},
                                      {"rmse_xy_m", number(c.rmse_m)},
                                      {"rotor_sd_radps", number(c.rotor_sd_radps)},
                                      {"rotor_rate_radps2", number(c.rotor_rate_radps2)},
                                      {"behind_best_m", number(c.behind_m)},
                                      {"behind_best_95", {number(c.behind.low), number(c.behind.high)}},
                                      {"as_good_as_best", c.as_good_as_best},
                                      {"broken", c.broken}});
    if (!variant.alone.name.empty()) entry["alone"] = {{"axis", variant.alone.name}, {"value", variant.alone.value}};
    json["variants"].push_back(entry);
  }
  for (const Margin& margin : margins_of(variants)) {
    nlohmann::ordered_json entry{{"axis", margin.axis}, {"flown", margin.values}};
    for (std::size_t c = 0; c < margin.held.size(); ++c)
      entry["holds_up_to"][variants.front().controllers[c].name] =
          margin.held[c] == 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(margin.values[margin.held[c] - 1]);
    json["margins"].push_back(entry);
  }
  return config::json_text(json, 2) + "\n";
}

}  // namespace gustlab
