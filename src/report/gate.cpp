#include "report/gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "report/tables.hpp"

namespace gustlab {

namespace {

std::string cell_of(const ResultRow& row) { return fmt::format("{} {} {}", row.vehicle, row.trajectory, row.controller); }

using Identity = std::pair<std::string, std::int64_t>;
Identity identity(const ResultRow& row) { return {cell_of(row), row.replicate}; }

std::string judge(const ResultRow& now, const ResultRow& before, const GateTolerance& tolerance) {
  const bool completed = now.outcome == Outcome::completed;
  if (before.outcome != Outcome::completed) return "";
  if (!completed) return fmt::format("was completed, now {} at {:.3f} s", to_string(now.outcome), now.duration_s);
  std::string failure;
  for (const Metric& metric : tracking_metrics) {
    const double is = now.*metric.value, was = before.*metric.value;
    const double allowed = std::max(tolerance.absolute_m, tolerance.relative * was);
    // an error that is no longer a number fails too
    if (is - was <= allowed || (std::isnan(is) && std::isnan(was))) continue;
    failure += fmt::format("{}{} {:.4f} m, was {:.4f} m, allowed {:.4f} m", failure.empty() ? "" : "; ", metric.title, is, was, was + allowed);
  }
  return failure;
}

// mean paired difference of the planar RMSE of each cell, with its interval
std::string describe_changes(const std::map<Identity, const ResultRow*>& now, const std::vector<ResultRow>& baseline) {
  std::vector<std::string> order;
  std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> pairs;
  std::map<std::string, bool> configuration_changed;
  for (const ResultRow& before : baseline) {
    const auto found = now.find(identity(before));
    if (found == now.end()) continue;
    const std::string cell = cell_of(before);
    if (pairs.find(cell) == pairs.end()) order.push_back(cell);
    pairs[cell].first.push_back(found->second->rmse_xy_m);
    pairs[cell].second.push_back(before.rmse_xy_m);
    configuration_changed[cell] |= found->second->key != before.key;
  }
  std::string text = "| cell | N | RMSE before [m] | RMSE now [m] | paired change [m] | p | configuration |\n|---|--:|--:|--:|--:|--:|---|\n";
  for (const std::string& cell : order) {
    const auto& [is, was] = pairs[cell];
    const TTest test = paired_test(is, was);
    text += fmt::format("| {} | {} | {:.4f} | {:.4f} | {:+.4f} | {} | {} |\n", cell, is.size(), summarize(was).mean, summarize(is).mean,
                        test.difference, std::isnan(test.p_value) ? "–" : fmt::format("{:.2g}", test.p_value),
                        configuration_changed[cell] ? "changed" : "same");
  }
  return text;
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

}  // namespace

std::size_t GateReport::failures() const {
  return static_cast<std::size_t>(std::count_if(cases.begin(), cases.end(), [](const GateCase& one) { return !one.failure.empty(); }));
}

GateReport gate(const std::vector<ResultRow>& now, const std::vector<ResultRow>& baseline, const GateTolerance& tolerance) {
  std::map<Identity, const ResultRow*> rows;
  for (const ResultRow& row : now) rows[identity(row)] = &row;
  GateReport report;
  report.changes = describe_changes(rows, baseline);
  for (const ResultRow& before : baseline) {
    const auto found = rows.find(identity(before));
    const std::string failure = found == rows.end() ? "missing: the baseline has this run" : judge(*found->second, before, tolerance);
    report.cases.push_back({cell_of(before), before.replicate, failure});
    if (found != rows.end()) rows.erase(found);
  }
  // in plan order, not the map's
  for (const ResultRow& row : now)
    if (rows.count(identity(row)) > 0) report.cases.push_back({cell_of(row), row.replicate, "extra: the baseline does not have this run"});
  return report;
}

std::string to_junit(const GateReport& report) {
  std::string text = fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"gustlab gate\" tests=\"{}\" failures=\"{}\">\n",
                                 report.cases.size(), report.failures());
  for (const GateCase& one : report.cases) {
    text += fmt::format("  <testcase classname=\"{}\" name=\"replicate {}\"", xml_text(one.cell), one.replicate);
    text += one.failure.empty() ? "/>\n" : fmt::format("><failure message=\"{}\"/></testcase>\n", xml_text(one.failure));
  }
  return text + "</testsuite>\n";
}

std::string to_markdown(const GateReport& report) {
  std::string text = report.failures() == 0 ? fmt::format("**passed**: {} runs within tolerance of the baseline\n\n", report.cases.size())
                                            : fmt::format("**failed**: {} of {} runs\n\n", report.failures(), report.cases.size());
  for (const GateCase& one : report.cases)
    if (!one.failure.empty()) text += fmt::format("- {} replicate {}: {}\n", one.cell, one.replicate, one.failure);
  if (report.failures() > 0) text += "\n";
  return text + report.changes;
}

}  // namespace gustlab
