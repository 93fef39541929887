#include <fmt/format.h>

#include <algorithm>

#include "calibration/calibration.hpp"
#include "config/toml.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

using config::Table;

constexpr std::string_view calibration_format = "gustlab-calibration/1";

OpenParameter read_parameter(Table& table) {
  OpenParameter parameter{
      table.need_text("key"),     table.need_number("min"),          table.need_number("max"),
      table.need_number("start"), table.flag("log").value_or(false), table.text("unit").value_or(""),
      table.where("key")};
  if (!(parameter.min < parameter.max) || parameter.start < parameter.min || parameter.start > parameter.max)
    table.fail("start", "\"min\", \"start\" and \"max\" are out of order", "the search starts inside its range", "");
  if (parameter.log && parameter.min <= 0.0)
    table.fail("min", "\"min\" has no logarithm", "log = true", "write a number above zero");
  return parameter;
}

// without the key, the mean
std::vector<Statistic> read_statistics(Table& target) {
  std::vector<Statistic> statistics;
  for (const std::string& name : target.texts("statistics").value_or(std::vector<std::string>{"mean"})) {
    const auto place = std::find(statistic_names.begin(), statistic_names.end(), name);
    if (place == statistic_names.end())
      target.fail("statistics", fmt::format("\"{}\" is no statistic", name), "over runs, a table has mean and sd", "");
    statistics.push_back(static_cast<Statistic>(place - statistic_names.begin()));
  }
  return statistics;
}

CalibrationStage read_stage(Table& table) {
  CalibrationStage stage;
  stage.name = table.need_text("name");
  stage.evaluations = table.integer("evaluations").value_or(stage.evaluations);
  if (stage.evaluations < 1 || stage.evaluations > 1000000)
    table.fail("evaluations", "\"evaluations\" is out of range", "from 1 to 1000000", "");
  for (Table& target : table.tables("targets")) {
    const std::vector<Statistic> statistics = read_statistics(target);
    for (const std::string& trajectory : target.need_texts("trajectories"))
      for (const std::string& controller : target.need_texts("controllers"))
        for (const std::string& metric : target.need_texts("metrics"))
          for (const Statistic statistic : statistics)
            stage.targets.push_back({trajectory, controller, find_published_metric(metric, target.where("metrics")),
                                     statistic, target.where("controllers")});
  }
  for (Table& parameter : table.tables("parameters")) stage.parameters.push_back(read_parameter(parameter));
  if (stage.targets.empty()) table.fail("targets", "\"targets\" is empty", "a stage fits parameters to cells", "");
  if (stage.parameters.empty())
    table.fail("parameters", "\"parameters\" is empty", "a stage fits parameters to cells", "");
  return stage;
}

// [[known]]: cells, and why they are no blind predictions
void read_known(Table& table, std::vector<KnownCell>& known) {
  const std::string because = table.need_text("because");
  if (because != "by construction" && because != "chosen after seeing")
    table.fail("because", fmt::format("\"{}\" is no reason", because), "",
               "write \"by construction\" or \"chosen after seeing\"");
  for (const std::string& trajectory : table.need_texts("trajectories"))
    for (const std::string& controller : table.need_texts("controllers"))
      for (const std::string& metric : table.need_texts("metrics"))
        known.push_back({trajectory, controller, find_published_metric(metric, table.where("metrics")),
                         because == "by construction"});
}

}  // namespace

const KnownCell* Calibration::find_known(std::string_view trajectory, std::string_view controller,
                                         std::size_t metric) const {
  for (const KnownCell& cell : known)
    if (cell.trajectory == trajectory && cell.controller == controller && cell.metric == metric) return &cell;
  return nullptr;
}

bool Calibration::fits(std::string_view trajectory, std::string_view controller, std::size_t metric) const {
  for (const CalibrationStage& stage : stages)
    for (const Target& cell : stage.targets)
      if (cell.trajectory == trajectory && cell.controller == controller && cell.metric == metric) return true;
  return false;
}

std::string calibration_path(const std::string& experiment_path) {
  return experiment_path.substr(0, experiment_path.rfind(".toml")) + ".calibration.toml";
}

Calibration read_calibration(const std::string& path) {
  Table document = Table::read_file(path);
  if (document.need_text("format") != calibration_format)
    document.fail("format", "this is no calibration", "", fmt::format("write format = \"{}\"", calibration_format));
  Calibration calibration;
  calibration.table = document.need_text("table");
  calibration.first_replicate = document.integer("first_replicate").value_or(calibration.first_replicate);
  calibration.replicates = document.integer("replicates").value_or(calibration.replicates);
  calibration.first_where = document.where(document.has("first_replicate") ? "first_replicate" : "");
  calibration.count_where = document.where(document.has("replicates") ? "replicates" : "");
  for (Table& table : document.tables("stage")) calibration.stages.push_back(read_stage(table));
  for (Table& table : document.tables("known")) read_known(table, calibration.known);
  document.finish();
  return calibration;
}

}  // namespace gustlab
