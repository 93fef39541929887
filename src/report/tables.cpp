#include "report/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/toml.hpp"

namespace gustlab {

namespace {

std::string caption(const std::vector<TableCell>& cells, double settle_s) {
  std::size_t fewest = cells.empty() ? 0 : cells.front().total, most = fewest;
  for (const TableCell& cell : cells) {
    fewest = std::min(fewest, cell.total);
    most = std::max(most, cell.total);
  }
  const std::string runs = fewest == most ? fmt::format("{}", most) : fmt::format("{} to {}", fewest, most);
  return fmt::format(
      "Tracking error in m, planar unless z is named: mean ± sample standard deviation (median) over N = {} runs, samples from {} s on. "
      "A run that was not completed keeps its errors up to its end.",
      runs, config::shortest(settle_s));
}

// nothing of a figure that is not there
std::string fixed(double value) { return std::isnan(value) ? "–" : fmt::format("{:.3f}", value); }

std::string to_markdown(const std::vector<TableCell>& cells, const std::string& says) {
  std::string text = "| vehicle | trajectory | controller | completed |";
  for (const Metric& metric : tracking_metrics) text += fmt::format(" {} |", metric.title);
  text += "\n|---|---|---|--:|";
  for (std::size_t i = 0; i < tracking_metrics.size(); ++i) text += "--:|";
  for (const TableCell& cell : cells) {
    text += fmt::format("\n| {} | {} | {} | {}/{} |", cell.vehicle, cell.trajectory, cell.controller, cell.completed, cell.total);
    for (const Summary& error : cell.errors) text += fmt::format(" {} ± {} ({}) |", fixed(error.mean), fixed(error.sd), fixed(error.median));
  }
  return fmt::format("{}\n\n{}\n", text, says);
}

std::string to_csv(const std::vector<TableCell>& cells, double settle_s) {
  std::string text = "experiment,vehicle,trajectory,controller,settle_s,completed,total";
  for (const Metric& metric : tracking_metrics) text += fmt::format(",{0}_mean,{0}_sd,{0}_median", metric.name);
  const auto number = [](double value) { return std::isnan(value) ? "" : config::shortest(value); };
  for (const TableCell& cell : cells) {
    text += fmt::format("\n{},{},{},{},{},{},{}", cell.experiment, cell.vehicle, cell.trajectory, cell.controller,
                        config::shortest(settle_s), cell.completed, cell.total);
    for (const Summary& error : cell.errors) text += fmt::format(",{},{},{}", number(error.mean), number(error.sd), number(error.median));
  }
  return text + "\n";
}

std::string latex_text(std::string_view plain) {
  std::string text;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    if (plain.substr(i).starts_with("±")) {
      text += "$\\pm$";
      i += std::string_view("±").size() - 1;
    } else if (std::string_view("_%&#$").find(plain[i]) != std::string_view::npos) {
      text += std::string("\\") + plain[i];
    } else {
      text += plain[i];
    }
  }
  return text;
}

// mean and deviation in one siunitx number
std::string latex_number(const Summary& error) {
  if (std::isnan(error.mean)) return "--";
  if (std::isnan(error.sd)) return fmt::format("\\num{{{:.3f}}}", error.mean);
  return fmt::format("\\num{{{:.3f} +- {:.3f}}} (\\num{{{:.3f}}})", error.mean, error.sd, error.median);
}

std::string to_latex(const std::vector<TableCell>& cells, const std::string& says) {
  std::string text =
      "% \\usepackage{booktabs,siunitx}\n\\begin{table}\n\\centering\n\\sisetup{separate-uncertainty = true}\n";
  text += fmt::format("\\caption{{{}}}\n\\begin{{tabular}}{{lllr{}}}\n\\toprule\n", latex_text(says),
                      std::string(tracking_metrics.size(), 'r'));
  text += "Vehicle & Trajectory & Controller & Completed";
  for (const Metric& metric : tracking_metrics) text += fmt::format(" & {}", metric.title);
  text += " \\\\\n\\midrule\n";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const TableCell& cell = cells[i];
    // a rule between trajectories
    if (i > 0 && cell.trajectory != cells[i - 1].trajectory) text += "\\addlinespace\n";
    text += fmt::format("{} & {} & {} & {}/{}", latex_text(cell.vehicle), latex_text(cell.trajectory), latex_text(cell.controller),
                        cell.completed, cell.total);
    for (const Summary& error : cell.errors) text += fmt::format(" & {}", latex_number(error));
    text += " \\\\\n";
  }
  return text + "\\bottomrule\n\\end{tabular}\n\\end{table}\n";
}

std::string to_json(const std::vector<TableCell>& cells, const std::string& says, double settle_s) {
  nlohmann::ordered_json table{{"format", "gustlab-table/1"}, {"caption", says}, {"settle_s", settle_s}};
  table["cells"] = nlohmann::ordered_json::array();
  for (const TableCell& cell : cells) {
    nlohmann::ordered_json entry{{"experiment", cell.experiment}, {"vehicle", cell.vehicle},     {"trajectory", cell.trajectory},
                                 {"controller", cell.controller}, {"completed", cell.completed}, {"total", cell.total}};
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i) {
      const Summary& error = cell.errors[i];
      entry[std::string(tracking_metrics[i].name)] = {{"mean", error.mean}, {"sd", error.sd}, {"median", error.median}, {"n", error.n}};
    }
    table["cells"].push_back(std::move(entry));
  }
  return table.dump(2) + "\n";
}

}  // namespace

std::optional<TableFormat> find_table_format(std::string_view name) {
  if (name == "md") return TableFormat::md;
  if (name == "csv") return TableFormat::csv;
  if (name == "latex") return TableFormat::latex;
  if (name == "json") return TableFormat::json;
  return std::nullopt;
}

std::vector<TableCell> aggregate(const std::vector<ResultRow>& rows) {
  std::vector<TableCell> cells;
  std::vector<std::array<std::vector<double>, tracking_metrics.size()>> values;
  for (const ResultRow& row : rows) {
    const auto same = [&](const TableCell& cell) {
      return cell.experiment == row.experiment && cell.vehicle == row.vehicle && cell.trajectory == row.trajectory &&
             cell.controller == row.controller;
    };
    const auto place = static_cast<std::size_t>(std::find_if(cells.begin(), cells.end(), same) - cells.begin());
    if (place == cells.size()) {
      cells.push_back({row.experiment, row.vehicle, row.trajectory, row.controller, 0, 0, {}});
      values.emplace_back();
    }
    ++cells[place].total;
    if (row.outcome == Outcome::completed) ++cells[place].completed;
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i) values[place][i].push_back(row.*tracking_metrics[i].value);
  }
  for (std::size_t place = 0; place < cells.size(); ++place)
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i) cells[place].errors[i] = summarize(values[place][i]);
  return cells;
}

std::string to_table(const Results& results, TableFormat format) {
  const std::vector<TableCell> cells = aggregate(results.rows);
  const std::string says = caption(cells, results.settle_s);
  switch (format) {
    case TableFormat::md: return to_markdown(cells, says);
    case TableFormat::csv: return to_csv(cells, results.settle_s);
    case TableFormat::latex: return to_latex(cells, says);
    case TableFormat::json: return to_json(cells, says, results.settle_s);
  }
  return {};
}

}  // namespace gustlab
