#include "calibration/published.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

constexpr std::string_view published_format = "gustlab-published/1";

using config::Table;

std::size_t need_metric(Table& table, std::string_view key) {
  return find_published_metric(table.need_text(key), table.where(key));
}

PublishedRow read_row(Table& table) {
  PublishedRow row{table.need_text("table"), table.need_text("trajectory"), table.need_text("controller"), {}};
  const auto n = static_cast<std::size_t>(table.need_number("n"));
  for (std::size_t i = 0; i < published_metrics.size(); ++i) {
    const auto figure = table.numbers(published_metrics[i]);
    if (!figure || figure->size() != 2 || !((*figure)[0] > 0.0) || (*figure)[1] < 0.0)
      table.fail(published_metrics[i], fmt::format("\"{}\" is no figure", published_metrics[i]),
                 "a mean above zero and a standard deviation", "write [0.25, 0.07]");
    row.figures[i] = {n, (*figure)[0], (*figure)[1], std::numeric_limits<double>::quiet_NaN()};
  }
  return row;
}

// each pair of a chain is a claim
void read_orders(Table& document, std::vector<Claim>& claims) {
  for (Table& table : document.tables("orders")) {
    const std::string name = table.need_text("table"), trajectory = table.need_text("trajectory");
    const std::vector<std::string> controllers = table.need_texts("controllers");
    for (const std::string& metric : table.need_texts("metrics"))
      for (std::size_t k = 0; k < controllers.size(); ++k)
        for (std::size_t more = k + 1; more < controllers.size(); ++more)
          claims.push_back({ClaimKind::less,
                            {name, trajectory, controllers[k]},
                            {name, trajectory, controllers[more]},
                            find_published_metric(metric, table.where("metrics")),
                            0.0,
                            true,
                            "",
                            {}});
  }
  for (Table& table : document.tables("trajectory_orders")) {
    const std::string name = table.need_text("table"), controller = table.need_text("controller");
    const std::vector<std::string> trajectories = table.need_texts("trajectories");
    const std::size_t metric = need_metric(table, "metric");
    for (std::size_t k = 0; k < trajectories.size(); ++k)
      for (std::size_t more = k + 1; more < trajectories.size(); ++more)
        claims.push_back({ClaimKind::less,
                          {name, trajectories[k], controller},
                          {name, trajectories[more], controller},
                          metric,
                          0.0,
                          true,
                          "",
                          {}});
  }
}

// `controller` against `than` on one trajectory and metric
void read_pairs(Table& document, std::string_view key, ClaimKind kind, std::vector<Claim>& claims) {
  for (Table& table : document.tables(key)) {
    const std::string name = table.need_text("table"), trajectory = table.need_text("trajectory");
    Claim claim{kind,
                {name, trajectory, table.need_text("controller")},
                {name, trajectory, table.need_text("than")},
                need_metric(table, "metric"),
                0.0,
                true,
                "",
                {}};
    if (kind == ClaimKind::reduced) claim.by = table.need_number("by");
    claims.push_back(claim);
  }
}

void read_others(Table& document, std::vector<Claim>& claims) {
  for (Table& table : document.tables("runaways"))
    claims.push_back({ClaimKind::runaway,
                      {table.need_text("table"), "", table.need_text("controller")},
                      {},
                      find_published_metric("max_xy_m", ""),
                      0.0,
                      true,
                      "",
                      {}});
  for (Table& table : document.tables("completions"))
    claims.push_back({ClaimKind::completion,
                      {table.need_text("table"), "", table.need_text("controller")},
                      {},
                      0,
                      0.0,
                      table.flag("all").value_or(true),
                      "",
                      {}});
  for (Table& table : document.tables("below"))
    claims.push_back({ClaimKind::below,
                      {table.need_text("table"), "", ""},
                      {table.need_text("than"), "", ""},
                      0,
                      0.0,
                      true,
                      table.need_text("except_trajectory"),
                      need_metric(table, "except_metric")});
}

}  // namespace

std::size_t find_published_metric(const std::string& name, const std::string& where) {
  const auto place = std::find(published_metrics.begin(), published_metrics.end(), name);
  if (place == published_metrics.end())
    throw ConfigError(
        fmt::format("{}: \"{}\" is no metric (a table has {})", where, name, fmt::join(published_metrics, ", ")));
  return static_cast<std::size_t>(place - published_metrics.begin());
}

const PublishedRow* Published::find(std::string_view table, std::string_view trajectory,
                                    std::string_view controller) const {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const PublishedRow& candidate) {
    return candidate.table == table && candidate.trajectory == trajectory && candidate.controller == controller;
  });
  return row == rows.end() ? nullptr : &*row;
}

void Published::check_vehicle(const std::string& table, const Experiment& experiment) const {
  const auto of = vehicles.find(table);
  if (of != vehicles.end() && of->second != experiment.vehicle.name)
    throw ConfigError(
        fmt::format("{}: {} flies {} (the paper's is of {}); its figures are not to be compared with another vehicle's",
                    table, experiment.name, experiment.vehicle.name, of->second));
}

Published read_published(const std::string& path) {
  Table document = Table::read_file(path);
  if (document.need_text("format") != published_format)
    document.fail("format", "this is no table of published figures", "",
                  fmt::format("write format = \"{}\"", published_format));
  Published published;
  for (Table& table : document.tables("vehicles"))
    published.vehicles[table.need_text("table")] = table.need_text("vehicle");
  for (Table& table : document.tables("rows")) published.rows.push_back(read_row(table));
  read_orders(document, published.claims);
  read_pairs(document, "reductions", ClaimKind::reduced, published.claims);
  read_pairs(document, "steadier", ClaimKind::steadier, published.claims);
  read_others(document, published.claims);
  document.finish();
  return published;
}

}  // namespace gustlab
