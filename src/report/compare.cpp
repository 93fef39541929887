#include "report/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr double least_completed = 0.95, most_growth = 2.0;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool holds(const ComparedController& controller) {
  return static_cast<double>(controller.completed) >= least_completed * static_cast<double>(controller.total);
}

// errors per controller, in one order of the runs; NaN where a run was not completed
struct Errors {
  std::vector<std::string> names, runs;
  std::vector<std::vector<double>> rmse_m;
};
Errors errors_of(const Results& results) {
  Errors errors;
  std::vector<std::vector<std::string>> runs;
  for (const ResultRow& row : results.rows) {
    const auto at = static_cast<std::size_t>(std::find(errors.names.begin(), errors.names.end(), row.controller) - errors.names.begin());
    if (at == errors.names.size()) {
      errors.names.push_back(row.controller);
      errors.rmse_m.emplace_back();
      runs.emplace_back();
    }
    errors.rmse_m[at].push_back(row.outcome == Outcome::completed ? row.rmse_xy_m : nan);
    runs[at].push_back(fmt::format("{} {}", row.trajectory, row.replicate));
  }
  for (const auto& other : runs)
    if (other != runs.front()) throw DataError(results.rows.front().experiment + ": its controllers did not fly the same runs (a comparison is paired)");
  if (!runs.empty()) errors.runs = runs.front();
  return errors;
}

ComparedVariant compare_one(const std::string& name, const Errors& errors) {
  ComparedVariant variant{name, 0, {}};
  for (std::size_t c = 0; c < errors.names.size(); ++c) {
    ComparedController controller;
    const Summary summary = summarize(errors.rmse_m[c]);
    controller.name = errors.names[c];
    controller.completed = summary.n;
    controller.total = errors.runs.size();
    controller.completion = wilson_interval(summary.n, controller.total);
    controller.rmse_m = summary.mean;
    variant.controllers.push_back(controller);
  }
  const auto better = [](const ComparedController& a, const ComparedController& b) {
    if (holds(a) != holds(b)) return holds(a);
    if (!holds(a) && a.completed != b.completed) return a.completed > b.completed;
    return a.rmse_m < b.rmse_m;
  };
  variant.best = static_cast<std::size_t>(std::min_element(variant.controllers.begin(), variant.controllers.end(), better) - variant.controllers.begin());
  for (std::size_t c = 0; c < errors.names.size(); ++c) {
    ComparedController& controller = variant.controllers[c];
    controller.behind_m = paired_test(errors.rmse_m[c], errors.rmse_m[variant.best]).difference;
    // the same resamples for every pair
    controller.behind = paired_bootstrap(errors.rmse_m[c], errors.rmse_m[variant.best], RandomStream(1, 0, "compare"));
    controller.as_good_as_best = c == variant.best || (holds(controller) == holds(variant.controllers[variant.best]) && controller.behind.low <= 0.0);
  }
  return variant;
}

std::string cell(const ComparedController& controller, bool best) {
  std::string text = std::isnan(controller.rmse_m) ? "–" : fmt::format("{:.3f}", controller.rmse_m);
  if (best) text = "**" + text + "**";
  if (controller.completed < controller.total) text += fmt::format(" ({}/{})", controller.completed, controller.total);
  if (controller.broken) text += " †";
  return text;
}

}  // namespace

std::vector<ComparedVariant> compare(std::span<const NamedResults> variants) {
  std::vector<ComparedVariant> compared;
  Errors first;
  for (const auto& [name, results] : variants) {
    const Errors errors = errors_of(results);
    if (compared.empty()) first = errors;
    if (errors.names != first.names || errors.runs != first.runs)
      throw DataError(fmt::format("{} and {} do not have the same controllers and runs (a comparison is paired)", variants.front().name, name));
    ComparedVariant& variant = compared.emplace_back(compare_one(name, errors));
    for (std::size_t c = 0; c < variant.controllers.size(); ++c) {
      ComparedController& controller = variant.controllers[c];
      controller.broken = !holds(controller) || controller.rmse_m > most_growth * compared.front().controllers[c].rmse_m;
    }
  }
  return compared;
}

std::string to_markdown(std::span<const ComparedVariant> variants) {
  const std::vector<ComparedController>& columns = variants.front().controllers;
  std::string text = "| variant |";
  for (const ComparedController& controller : columns) text += fmt::format(" {} |", controller.name);
  text += " best, or not told from it | ahead of the next by |\n|---|";
  for (std::size_t i = 0; i < columns.size(); ++i) text += "--:|";
  text += "---|--:|";
  for (const ComparedVariant& variant : variants) {
    text += fmt::format("\n| {} |", variant.name);
    std::vector<std::string> good{variant.controllers[variant.best].name};
    const ComparedController* next = nullptr;
    for (std::size_t c = 0; c < variant.controllers.size(); ++c) {
      const ComparedController& controller = variant.controllers[c];
      text += fmt::format(" {} |", cell(controller, c == variant.best));
      if (c == variant.best) continue;
      if (controller.as_good_as_best) good.push_back(controller.name);
      else if (holds(controller) && (next == nullptr || controller.behind_m < next->behind_m)) next = &controller;
    }
    text += fmt::format(" {} |", fmt::join(good, ", "));
    text += next == nullptr ? " – |" : fmt::format(" {}: {:.4f} [{:.4f}, {:.4f}] |", next->name, next->behind_m, next->behind.low, next->behind.high);
  }
  text += fmt::format("\n\nMean planar RMSE in m over the runs that were completed, of {} in each cell, the same gusts for all; completed/all where a run "
                      "was not. In brackets the 95 % interval of the paired difference (bootstrap). † broken: fewer than 95 % completed, or more than "
                      "twice its own error in {}.\n\n| controller | best in | breaks in |\n|---|---|---|\n", columns.front().total, variants.front().name);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    std::vector<std::string> best, broken;
    for (const ComparedVariant& variant : variants) {
      if (variant.controllers[c].as_good_as_best) best.push_back(variant.name);
      if (variant.controllers[c].broken) broken.push_back(variant.name);
    }
    text += fmt::format("| {} | {} | {} |\n", columns[c].name, best.empty() ? "–" : fmt::format("{}", fmt::join(best, ", ")),
                        broken.empty() ? "–" : fmt::format("{}", fmt::join(broken, ", ")));
  }
  return text;
}

std::string to_json(std::span<const ComparedVariant> variants) {
  nlohmann::ordered_json json{{"format", "gustlab-comparison/1"}, {"variants", nlohmann::ordered_json::array()}};
  const auto number = [](double value) { return std::isnan(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value); };
  for (const ComparedVariant& variant : variants) {
    nlohmann::ordered_json entry{{"variant", variant.name}, {"best", variant.controllers[variant.best].name}};
    for (const ComparedController& c : variant.controllers)
      entry["controllers"].push_back({{"controller", c.name}, {"completed", c.completed}, {"total", c.total},
                                      {"completion_95", {c.completion.low, c.completion.high}}, {"rmse_xy_m", number(c.rmse_m)},
                                      {"behind_best_m", number(c.behind_m)}, {"behind_best_95", {number(c.behind.low), number(c.behind.high)}},
                                      {"as_good_as_best", c.as_good_as_best}, {"broken", c.broken}});
    json["variants"].push_back(entry);
  }
  return json.dump(2) + "\n";
}

}  // namespace gustlab
