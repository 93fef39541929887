#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "commands.hpp"
#include "gustlab/errors.hpp"
#include "report/tables.hpp"
#include "sweep/sweep.hpp"

namespace gustlab {

namespace {

struct TableArguments {
  std::string folder, format = "md";
  std::vector<std::string> columns, names;
  TableOptions table;
};

void table_command(TableArguments options) {
  options.table.format = find_table_format(options.format).value();
  if (!options.columns.empty()) options.table.columns.clear();
  for (const std::string& column : options.columns) {
    const auto metric = find_tracking_metric(column);
    if (!metric)
      throw ConfigError(
          fmt::format("--columns {}: no such figure (a table has rmse, mae, p95, max and rmse_z)", column));
    options.table.columns.push_back(*metric);
  }
  for (const std::string& name : options.names) {
    const std::size_t equals = name.find('=');
    if (equals == std::string::npos)
      throw ConfigError(fmt::format(
          "--names {}: not a name (ours=theirs) for example --names daiml=ADAIML,lemniscate=infinity", name));
    options.table.names[name.substr(0, equals)] = name.substr(equals + 1);
  }
  const std::string text = to_table(read_results(options.folder), options.table);
  std::fwrite(text.data(), 1, text.size(), stdout);
}

}  // namespace

void add_table(CLI::App& app) {
  const auto options = std::make_shared<TableArguments>();
  CLI::App* command = app.add_subcommand(
      "table", "prints a sweep, all its variants in one: mean ± sd (median) over runs, completed of all");
  command->add_option("DIR", options->folder, "folder of a finished sweep")->required();
  command->add_option("--format", options->format, "latex: the layout of the paper's tables")
      ->check(CLI::IsMember({"md", "csv", "latex", "json"}))
      ->capture_default_str();
  command->add_option("--columns", options->columns, "figures to show: rmse, mae, p95, max, rmse_z")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_flag("--bold-best", options->table.bold_best, "the least mean of each trajectory in bold");
  command->add_option("--names", options->names, "what the table calls ours: daiml=ADAIML,lemniscate=infinity")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--label", options->table.label, "LaTeX label behind tab:, instead of the experiment's name");
  command->callback([options] { table_command(*options); });
}

}  // namespace gustlab
