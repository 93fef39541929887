#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>

#include "commands.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/flight_log.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "report/sweep_page.hpp"
#include "report/tables.hpp"
#include "sweep/sweep.hpp"

namespace gustlab {

namespace {

struct TableArguments {
  std::string folder, format = "md";
  std::vector<std::string> columns, names;
  TableOptions table;
};

constexpr std::size_t most_points = 400;  // of a path on the page

std::vector<double> thinned(const FlightLog& log, std::string_view column) {
  const std::vector<double>* values = log.find(column);
  std::vector<double> some;
  const std::size_t step = std::max<std::size_t>(1, log.rows() / most_points);
  for (std::size_t row = 0; values && row < log.rows(); row += step) some.push_back((*values)[row]);
  return some;
}

// the row in the middle of every axis
const ResultRow& middle_row(const std::vector<ResultRow>& rows) {
  std::vector<std::vector<std::string>> values(rows.front().axes.size());
  for (const ResultRow& row : rows)
    for (std::size_t a = 0; a < values.size(); ++a)
      if (std::find(values[a].begin(), values[a].end(), row.axes[a].value) == values[a].end())
        values[a].push_back(row.axes[a].value);
  for (const ResultRow& row : rows) {
    bool middle = true;
    for (std::size_t a = 0; a < values.size(); ++a)
      middle = middle && row.axes[a].value == values[a][values[a].size() / 2];
    if (middle) return row;
  }
  return rows.front();
}

// the logs of one replicate at one point of the axes, where `sweep --logs` wrote them; the middle point first
SweepFigures paths_in(const std::filesystem::path& folder, const std::vector<ResultRow>& rows) {
  SweepFigures figures;
  for (const ResultRow* wanted : {&middle_row(rows), &rows.front()}) {
    const std::size_t dot = wanted->experiment.find('.');
    const bool whole = dot == std::string::npos;
    const std::filesystem::path place = whole ? folder : folder / wanted->experiment.substr(dot + 1);
    for (const ResultRow& row : rows) {
      if (row.experiment != wanted->experiment || row.replicate != rows.front().replicate) continue;
      const auto path = place / fmt::format("{}_{}_{}.csv", row.trajectory, row.controller, row.replicate);
      if (!std::filesystem::exists(path)) continue;
      const FlightLog log = read_flight_log(path.string());
      figures.paths.push_back({row.trajectory, row.controller, thinned(log, "px"), thinned(log, "py"),
                               thinned(log, "rpx"), thinned(log, "rpy")});
    }
    if (figures.paths.empty()) continue;
    std::string point;
    for (const auto& axis : wanted->axes)
      point += fmt::format("{} {} {}", point.empty() ? " at" : ",", axis.name, axis.value);
    figures.paths_of = fmt::format("Replicate {}{}: all met the same gust.", rows.front().replicate, point);
    break;
  }
  return figures;
}

// what a table calls by name
using NamesByKind = std::map<std::string, std::set<std::string>>;
NamesByKind names_here(const std::vector<ResultRow>& rows) {
  NamesByKind kinds;
  for (const ResultRow& row : rows) {
    kinds["vehicles"].insert(row.vehicle);
    kinds["trajectories"].insert(row.trajectory);
    kinds["controllers"].insert(row.controller);
    for (const NamedValue& axis : row.axes) kinds["axes"].insert(axis.name);
  }
  return kinds;
}

// one list of names may serve many tables, so a name that this one does not have is no error
void warn_of_unused(const std::map<std::string, std::string>& names, const NamesByKind& kinds) {
  std::set<std::string> here;
  for (const auto& [kind, ours] : kinds) here.insert(ours.begin(), ours.end());
  const std::vector<std::string> known(here.begin(), here.end());
  for (const auto& [ours, theirs] : names)
    if (here.count(ours) == 0)
      spdlog::warn(worded(fmt::format("--names {}={}: this table has no {}", ours, theirs, ours), "",
                          config::suggest(ours, known)));
}

// two rows of one name are two vehicles, trajectories, controllers or axes that nobody tells apart
void check_names_differ(const std::map<std::string, std::string>& names, const NamesByKind& kinds) {
  for (const auto& [kind, ours] : kinds) {
    std::map<std::string, std::string> called;  // in the table → here
    for (const std::string& name : ours) {
      const auto known = names.find(name);
      const std::string theirs = known == names.end() ? name : known->second;
      const auto [first, is_new] = called.try_emplace(theirs, name);
      if (!is_new)
        throw ConfigError(fmt::format("--names: two {} would be called {} ({} and {}); choose another name", kind,
                                      theirs, first->second, name));
    }
  }
}

void check_format_reads(const CLI::App& command, const std::string& format) {
  const std::string chosen = "format " + format;
  const bool text = format == "md" || format == "latex";
  check_is_read(command, {"--label"}, format == "latex", chosen, "latex");
  check_is_read(command, {"--bold-best", "--names"}, text, chosen, "md and latex");
  check_is_read(command, {"--columns"}, text || format == "csv", chosen, "md, csv and latex");
}

std::vector<std::size_t> columns_of(const std::vector<std::string>& words) {
  std::vector<std::size_t> columns;
  for (const std::string& word : words) {
    const auto metric = find_tracking_metric(word);
    if (!metric)
      throw ConfigError(fmt::format("--columns {}: no such figure (a table has rmse, mae, p95, max and rmse_z)", word));
    if (std::find(columns.begin(), columns.end(), *metric) != columns.end())
      throw ConfigError(fmt::format("--columns {}: is given twice; leave one out", word));
    columns.push_back(*metric);
  }
  return columns;
}

std::map<std::string, std::string> names_of(const std::vector<std::string>& words) {
  std::map<std::string, std::string> names;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size())
      throw ConfigError(fmt::format(
          "--names {}: not a name (ours=theirs); for example --names daiml=ADAIML,lemniscate=infinity", word));
    if (!names.emplace(word.substr(0, equals), word.substr(equals + 1)).second)
      throw ConfigError(fmt::format("--names {}: {} is given twice; leave one out", word, word.substr(0, equals)));
  }
  return names;
}

// LaTeX takes a label as it stands: nothing in it can be escaped
void check_label(const std::string& label) {
  if (const std::size_t wrong = label.find_first_of("\\{}%#$&~^"); wrong != std::string::npos)
    throw ConfigError(fmt::format("--label {}: LaTeX takes no {} in a label; letters, digits, _, - and : make one",
                                  label, label[wrong]));
}

void table_command(TableArguments options, const CLI::App& command) {
  check_format_reads(command, options.format);
  check_label(options.table.label);
  if (options.format == "html") {
    const Results results = read_results(options.folder);
    if (results.rows.empty())
      throw DataError(fmt::format("{}: no runs (nothing to show); sweep first", options.folder));
    const std::string page = sweep_page(results, paths_in(options.folder, results.rows));
    std::fwrite(page.data(), 1, page.size(), stdout);
    return;
  }
  options.table.format = find_table_format(options.format).value();
  if (!options.columns.empty()) options.table.columns = columns_of(options.columns);
  options.table.names = names_of(options.names);
  const Results results = read_results(options.folder);
  const NamesByKind here = names_here(results.rows);
  check_names_differ(options.table.names, here);
  warn_of_unused(options.table.names, here);
  const std::string text = to_table(results, options.table);
  if (options.format == "md") say_on_stdout(text);
  else std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace

void add_table(CLI::App& app) {
  const auto options = std::make_shared<TableArguments>();
  CLI::App* command = app.add_subcommand(
      "table", "prints a sweep, all its variants in one: mean ± sd (median) over runs, completed of all");
  command->add_option("DIR", options->folder, "folder of a finished sweep")->required();
  command
      ->add_option("--format", options->format,
                   "latex: the layout of the paper's tables; html: one page of table, heat maps, paths and failures")
      ->check(CLI::IsMember({"md", "csv", "latex", "json", "html"}))
      ->capture_default_str();
  command
      ->add_option("--columns", options->columns,
                   "figures to show, separated by commas: rmse, mae, p95, max, rmse_z (md, csv, latex)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_flag("--bold-best", options->table.bold_best,
                    "the least mean of each trajectory in bold, of those that completed most (md, latex)");
  command
      ->add_option("--names", options->names,
                   "what the table calls ours, separated by commas: daiml=ADAIML,lemniscate=infinity (md, latex)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--label", options->table.label, "label behind tab:, instead of the experiment's name (latex)");
  command->callback([options, command] { table_command(*options, *command); });
}

}  // namespace gustlab
