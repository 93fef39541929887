#include "report/gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr std::size_t most_listed = 20;  // failures in the summary
constexpr double significant = 0.05;     // of one cell's improvement, which decides nothing

using CellName = std::pair<std::string, std::string>;
CellName cell_of(const ResultRow& row) {
  return {row.experiment, fmt::format("{} {} {}", row.vehicle, row.trajectory, row.controller)};
}

using Identity = std::pair<CellName, std::int64_t>;
using RowsById = std::map<Identity, const ResultRow*>;
RowsById by_identity(const std::vector<ResultRow>& rows) {
  RowsById known;
  for (const ResultRow& row : rows) known[{cell_of(row), row.replicate}] = &row;
  return known;
}

std::string experiments_of(const std::vector<ResultRow>& rows) {
  std::set<std::string> names;
  for (const ResultRow& row : rows) names.insert(without_variant(row.experiment));
  return fmt::format("{}", fmt::join(names, ", "));
}

// a cell as the summary calls it: its variant first, where there are any
std::string title_of(const GateCell& cell) {
  const std::size_t dot = cell.experiment.find('.');
  return dot == std::string::npos ? cell.cell : fmt::format("{}: {}", cell.experiment.substr(dot + 1), cell.cell);
}

void check_same_experiment(const RowsById& now_rows, const std::vector<ResultRow>& now,
                           const std::vector<ResultRow>& baseline) {
  const bool known = std::any_of(baseline.begin(), baseline.end(), [&](const ResultRow& row) {
    return now_rows.lower_bound({cell_of(row), 0}) != now_rows.end() &&
           now_rows.lower_bound({cell_of(row), 0})->first.first == cell_of(row);
  });
  if (!known)
    throw DataError(
        fmt::format("wrong baseline: it is of {}, the sweep of {} (they have no variant, trajectory and controller in "
                    "common); give the baseline of "
                    "this experiment, "
                    "or make one with --update",
                    experiments_of(baseline), experiments_of(now)));
}

// the runs of a cell that both completed, by metric
struct Pairs {
  std::array<std::vector<double>, tracking_metrics.size()> now, before;
};

void add_pair(const ResultRow& now, const ResultRow& before, Pairs& pairs, GateCell& cell) {
  cell.configuration_changed |= now.key != before.key;
  if (before.outcome != Outcome::completed) return;
  if (now.outcome != Outcome::completed) {
    cell.failures.push_back(fmt::format("replicate {} was completed, now {} at {:.3f} s", now.replicate,
                                        to_string(now.outcome), now.duration_s));
    return;
  }
  ++cell.pairs;
  for (std::size_t i = 0; i < tracking_metrics.size(); ++i) {
    const double is = now.*tracking_metrics[i].value, was = before.*tracking_metrics[i].value;
    if (std::isnan(is) && !std::isnan(was))
      cell.failures.push_back(
          fmt::format("replicate {}: {} is no longer a number", now.replicate, tracking_metrics[i].title));
    pairs.now[i].push_back(is);
    pairs.before[i].push_back(was);
  }
}

GateChange change_of(const std::vector<double>& now, const std::vector<double>& before) {
  const TTest test = paired_test(now, before);
  const double half = 0.5 * test.p_value;
  return {summarize(before).mean,
          summarize(now).mean,
          test.difference,
          paired_interval(now, before, 0.90),
          test.difference > 0.0 ? half : 1.0 - half,
          test.difference < 0.0 ? half : 1.0 - half};
}

// a change as a share of what was, with sign; "–": it was nothing
std::string percent(double change_m, double before_m, int digits) {
  return before_m > 0.0 ? fmt::format("{:+.{}f}", 100.0 * change_m / before_m, digits) : "–";
}

std::string verdict_of(const GateCell& cell, double margin) {
  if (cell.failures.size() > cell.unpaired) return "**worse**";
  if (cell.unpaired > 0) return "**other runs**";
  const GateChange& rmse = cell.changes[0];
  const double allowed = margin * rmse.before_m;
  if (rmse.p_better < significant && rmse.change_m < 0.0) return "improved";
  return rmse.interval_m.low >= -allowed && rmse.interval_m.high <= allowed ? "equivalent" : "cannot tell";
}

// which metrics of which cells rose too far or significantly
void judge(std::vector<GateCell>& cells, const GateRule& rule) {
  std::vector<double> p_values;
  for (const GateCell& cell : cells)
    for (const GateChange& change : cell.changes) p_values.push_back(change.p_worse);
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i) {
      const GateChange& change = cells[c].changes[i];
      const double p = adjusted[c * tracking_metrics.size() + i];
      const bool too_far = rule.by_margin && change.change_m > rule.margin * change.before_m,
                 surely = rule.by_test && p < rule.level;
      if (!(change.change_m > rule.floor_m) || !(too_far || surely)) continue;
      cells[c].failures.push_back(
          fmt::format("{} {:.4f} m, was {:.4f} m: {} %{}{}", tracking_metrics[i].title, change.now_m, change.before_m,
                      percent(change.change_m, change.before_m, 1), too_far ? ", beyond the margin" : "",
                      surely ? fmt::format(", significant (p = {:.2g})", p) : ""));
    }
    cells[c].verdict = verdict_of(cells[c], rule.margin);
  }
}

// a gate that compares nothing would pass whatever the sweep has become
void fail_if_nothing_is_compared(std::vector<GateCell>& cells) {
  for (const GateCell& cell : cells)
    for (const GateChange& change : cell.changes)
      if (!std::isnan(change.change_m)) return;
  for (GateCell& cell : cells) {
    if (!cell.failures.empty()) continue;
    cell.failures.push_back("nothing is compared (no cell has a run that was completed, and has an error, in both)");
    cell.verdict = "**not compared**";
  }
}

std::string rule_text(const GateRule& rule) {
  std::vector<std::string> parts;
  if (rule.by_margin) parts.push_back(fmt::format("by more than {:.3g} %", 100.0 * rule.margin));
  if (rule.by_test)
    parts.push_back(fmt::format("significantly (paired t-test, p < {:.3g} over all tests after Holm)", rule.level));
  const std::string rises = parts.empty() ? "" : fmt::format("whose mean error rose {}, or ", fmt::join(parts, " or "));
  return fmt::format(
      "Fails: a cell {}with a run that is no longer completed or missing{}. equivalent: the 90 % interval of the "
      "change is within "
      "±{:.3g} %.",
      rises, rule.allow_extra ? "" : ", or that the baseline does not have", 100.0 * rule.margin);
}

std::string xml_text(std::string_view plain) {
  std::string text;
  for (const char c : plain) {
    if (c == '&') text += "&amp;";
    else if (c == '<') text += "&lt;";
    else if (c == '>') text += "&gt;";
    else if (c == '"') text += "&quot;";
    else text += c;
  }
  return text;
}

std::string change_row(const GateCell& cell) {
  const GateChange& rmse = cell.changes[0];
  const std::string name = fmt::format("| {} | {} |", title_of(cell), cell.pairs);
  if (cell.pairs == 0) return fmt::format("{} – | – | – | – | {} | – |\n", name, cell.verdict);
  const auto share = [&](double value_m) { return percent(value_m, rmse.before_m, 2); };
  const std::string interval = std::isnan(rmse.interval_m.low) || !(rmse.before_m > 0.0)
                                   ? "–"
                                   : fmt::format("{} to {}", share(rmse.interval_m.low), share(rmse.interval_m.high));
  return fmt::format("{} {:.4f} | {:.4f} | {} | {} | {} | {} |\n", name, rmse.before_m, rmse.now_m,
                     share(rmse.change_m), interval, cell.verdict, cell.configuration_changed ? "changed" : "same");
}

}  // namespace

std::size_t GateReport::failures() const {
  return static_cast<std::size_t>(
      std::count_if(cells.begin(), cells.end(), [](const GateCell& cell) { return !cell.failures.empty(); }));
}

GateReport gate(const std::vector<ResultRow>& now, const std::vector<ResultRow>& baseline, const GateRule& rule) {
  RowsById rows = by_identity(now);
  check_same_experiment(rows, now, baseline);
  GateReport report{rule, baseline.size(), {}};
  std::vector<Pairs> pairs;
  std::map<CellName, std::size_t> places;
  const auto place_of = [&](const ResultRow& row) {
    const auto [place, is_new] = places.try_emplace(cell_of(row), report.cells.size());
    if (is_new) {
      report.cells.push_back({row.experiment, cell_of(row).second});
      pairs.emplace_back();
    }
    return place->second;
  };
  const auto unpaired = [&](const ResultRow& row, std::string_view why) {
    GateCell& cell = report.cells[place_of(row)];
    cell.failures.push_back(fmt::format("replicate {} is {}", row.replicate, why));
    ++cell.unpaired;
  };
  for (const ResultRow& before : baseline) {
    const std::size_t place = place_of(before);
    const auto found = rows.find({cell_of(before), before.replicate});
    if (found == rows.end()) {
      unpaired(before, "missing: the baseline has it");
      continue;
    }
    add_pair(*found->second, before, pairs[place], report.cells[place]);
    rows.erase(found);
  }
  // in plan order, not the map's
  for (const ResultRow& row : now)
    if (!rule.allow_extra && rows.count({cell_of(row), row.replicate}) > 0)
      unpaired(row, "extra: the baseline does not have it");
  for (std::size_t c = 0; c < pairs.size(); ++c)
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i)
      report.cells[c].changes[i] = change_of(pairs[c].now[i], pairs[c].before[i]);
  judge(report.cells, rule);
  fail_if_nothing_is_compared(report.cells);
  return report;
}

std::string to_junit(const GateReport& report) {
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"gustlab gate\" tests=\"{}\" failures=\"{}\">\n",
      report.cells.size(), report.failures());
  for (const GateCell& cell : report.cells) {
    text += fmt::format("  <testcase classname=\"{}\" name=\"{}\"", xml_text(cell.experiment), xml_text(cell.cell));
    text += cell.failures.empty() ? "/>\n"
                                  : fmt::format("><failure message=\"{}\"/></testcase>\n",
                                                xml_text(fmt::format("{}", fmt::join(cell.failures, "; "))));
  }
  return text + "</testsuite>\n";
}

std::string to_markdown(const GateReport& report) {
  const auto count = [&](std::string_view verdict) {
    return std::count_if(report.cells.begin(), report.cells.end(),
                         [&](const GateCell& cell) { return cell.verdict == verdict; });
  };
  std::string text =
      fmt::format("{}: {} of {} cells failed, {} improved, {} equivalent, of {} a change cannot be told; {} runs\n\n",
                  report.failures() == 0 ? "**passed**" : "**failed**", report.failures(), report.cells.size(),
                  count("improved"), count("equivalent"), count("cannot tell"), report.runs);
  text += rule_text(report.rule) + "\n\n";
  std::vector<std::string> failures;
  for (const GateCell& cell : report.cells)
    for (const std::string& failure : cell.failures)
      failures.push_back(fmt::format("- {}: {}\n", title_of(cell), failure));
  for (std::size_t i = 0; i < std::min(failures.size(), most_listed); ++i) text += failures[i];
  if (failures.size() > most_listed)
    text += fmt::format("- and {} more (--junit has all)\n", failures.size() - most_listed);
  if (!failures.empty()) text += "\n";
  text +=
      "| cell | N | RMSE before [m] | RMSE now [m] | paired change [%] | 90 % interval [%] | verdict | configuration "
      "|\n"
      "|---|--:|--:|--:|--:|--:|---|---|\n";
  for (const GateCell& cell : report.cells) text += change_row(cell);
  return text;
}

}  // namespace gustlab
