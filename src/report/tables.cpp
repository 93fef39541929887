#include "report/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/json_text.hpp"
#include "config/toml.hpp"

namespace gustlab {

namespace {

std::string named(const std::string& plain, const std::map<std::string, std::string>& names) {
  const auto known = names.find(plain);
  return known == names.end() ? plain : known->second;
}

// What the formats share: cells, their names, and which means are the best.
class Page {
 public:
  Page(const Results& results, const TableOptions& options)
      : cells(aggregate(results.rows)), settle_s(results.settle_s), options_(options), results_(results) {}

  std::string name(const std::string& plain) const { return named(plain, options_.names); }

  // the same table block: one trajectory at one point of the axes
  static bool together(const TableCell& a, const TableCell& b) {
    return a.experiment == b.experiment && a.vehicle == b.vehicle && a.trajectory == b.trajectory;
  }
  bool is_best(const TableCell& cell, std::size_t metric) const {
    if (!options_.bold_best || cell.errors[metric].n == 0) return false;
    return std::none_of(cells.begin(), cells.end(), [&](const TableCell& other) {
      return together(other, cell) && is_better(other, cell, metric);
    });
  }

  std::string caption() const {
    std::string text = fmt::format(
        "Tracking error in m, planar unless z is named: mean ± sample standard deviation{} over N = {} runs, samples "
        "from {} s on.",
        options_.format == TableFormat::latex ? "" : " (median)", runs_of_each(cells), config::shortest(settle_s));
    text += flown_in_words(results_, options_.names);
    if (std::any_of(cells.begin(), cells.end(), [](const TableCell& cell) { return cell.completed < cell.total; }))
      text +=
          " Completed: flown to the end, however large the error. A run that was not keeps its errors up to its end.";
    if (std::any_of(cells.begin(), cells.end(),
                    [](const TableCell& cell) { return cell.errors.front().n < cell.total; }))
      text += fmt::format(" n: so many runs have an error, and means are over these; the others ended before {} s.",
                          config::shortest(settle_s));
    return text;
  }

  std::vector<TableCell> cells;
  const double settle_s;

 private:
  const TableOptions& options_;
  const Results& results_;
};

std::vector<NamedValue> axes_of(const std::vector<TableCell>& cells) {
  return cells.empty() ? std::vector<NamedValue>{} : cells.front().axes;
}

// nothing of a figure that is not there
std::string fixed(double value) { return std::isnan(value) ? "–" : fmt::format("{:.3f}", value); }

// a bar would end the cell
std::string markdown_text(const std::string& plain) {
  std::string text;
  for (const char c : plain) {
    if (c == '|' || c == '\\') text += '\\';
    text += c;
  }
  return text;
}

std::string to_markdown(const Page& page, const TableOptions& options) {
  std::string text = "|", rule = "|";
  for (const NamedValue& axis : axes_of(page.cells)) {
    text += fmt::format(" {} |", markdown_text(page.name(axis.name)));
    rule += "--:|";
  }
  text += " vehicle | trajectory | controller | completed |";
  rule += "---|---|---|--:|";
  for (const std::size_t metric : options.columns) {
    text += fmt::format(" {} |", tracking_metrics[metric].title);
    rule += "--:|";
  }
  text += "\n" + rule;
  for (const TableCell& cell : page.cells) {
    text += "\n|";
    for (const NamedValue& axis : cell.axes) text += fmt::format(" {} |", axis.value);
    text += fmt::format(" {} | {} | {} | {} |", markdown_text(page.name(cell.vehicle)),
                        markdown_text(page.name(cell.trajectory)), markdown_text(page.name(cell.controller)),
                        completed_of(cell));
    for (const std::size_t metric : options.columns) {
      const Summary& error = cell.errors[metric];
      const std::string stars = page.is_best(cell, metric) ? "**" : "";
      text += fmt::format(" {}{} ± {}{} ({}) |", stars, fixed(error.mean), fixed(error.sd), stars, fixed(error.median));
    }
  }
  return fmt::format("{}\n\n{}\n", text, page.caption());
}

std::string to_csv(const Page& page, const TableOptions& options) {
  std::string text = "experiment,vehicle,trajectory,controller,settle_s,completed,total";
  for (const std::size_t metric : options.columns)
    text += fmt::format(",{0}_mean,{0}_sd,{0}_median", tracking_metrics[metric].name);
  text += ",counted";
  for (const NamedValue& axis : axes_of(page.cells)) text += "," + axis.name;
  const auto number = [](double value) { return std::isnan(value) ? "" : config::shortest(value); };
  for (const TableCell& cell : page.cells) {
    text += fmt::format("\n{},{},{},{},{},{},{}", cell.experiment, cell.vehicle, cell.trajectory, cell.controller,
                        config::shortest(page.settle_s), cell.completed, cell.total);
    for (const std::size_t metric : options.columns) {
      const Summary& error = cell.errors[metric];
      text += fmt::format(",{},{},{}", number(error.mean), number(error.sd), number(error.median));
    }
    text += fmt::format(",{}", cell.errors.front().n);
    for (const NamedValue& axis : cell.axes) text += "," + axis.value;
  }
  return text + "\n";
}

std::string latex_text(std::string_view plain) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> special{{{"±", "$\\pm$"},
                                                                                  {"\\", "\\textbackslash{}"},
                                                                                  {"~", "\\textasciitilde{}"},
                                                                                  {"^", "\\textasciicircum{}"},
                                                                                  {"–", "--"}}};
  std::string text;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const auto found = std::find_if(special.begin(), special.end(),
                                    [&](const auto& entry) { return plain.substr(i).starts_with(entry.first); });
    if (found != special.end()) {
      text += found->second;
      i += found->first.size() - 1;
      continue;
    }
    if (std::string_view("_%&#${}").find(plain[i]) != std::string_view::npos) text += '\\';
    text += plain[i];
  }
  return text;
}

std::string latex_number(const Summary& error, bool best) {
  if (std::isnan(error.mean)) return "--";
  std::string text = fmt::format("{:.3f}", error.mean);
  if (!std::isnan(error.sd)) text += fmt::format(" $\\pm$ {:.3f}", error.sd);
  return best ? "\\textbf{" + text + "}" : text;
}

// the layout of the paper's own tables: a block for each trajectory, a line for each controller
std::string to_latex(const Page& page, const TableOptions& options) {
  const std::vector<NamedValue> axes = axes_of(page.cells);
  const std::size_t leading = axes.size() + 1, all = leading + 1 + options.columns.size();
  std::string text = fmt::format(
      "% "
      "\\usepackage{{multirow}}\n\\begin{{table*}}[t]\n\\centering\n\\caption{{{}}}\n\\label{{tab:{}}}\n\\scriptsize\n",
      latex_text(page.caption()),
      options.label.empty() ? without_variant(page.cells.front().experiment) : options.label);
  text += "\\begin{tabular}{|";
  for (std::size_t i = 0; i < all; ++i) text += "c|";
  text += "}\n\\hline\n";
  for (const NamedValue& axis : axes) text += fmt::format("\\textbf{{{}}} & ", latex_text(page.name(axis.name)));
  text += "\\textbf{Trajectory} & \\textbf{Control}";
  std::string units;
  for (std::size_t i = 0; i < leading; ++i) units += " &";
  for (const std::size_t metric : options.columns) {
    text += fmt::format(" & \\textbf{{{}}}", tracking_metrics[metric].latex);
    units += " & \\textbf{[m]}";
  }
  text += " \\\\\n" + units + " \\\\\n\\hline\n";
  for (std::size_t i = 0; i < page.cells.size(); ++i) {
    const TableCell& cell = page.cells[i];
    const bool begins = i == 0 || !Page::together(cell, page.cells[i - 1]),
               ends = i + 1 == page.cells.size() || !Page::together(cell, page.cells[i + 1]);
    std::size_t rows = 0;
    for (const TableCell& other : page.cells) rows += Page::together(other, cell);
    for (const NamedValue& axis : cell.axes)
      text += (begins ? fmt::format("\\multirow{{{}}}{{*}}{{{}}}", rows, latex_text(axis.value)) : "") + " & ";
    if (begins) text += fmt::format("\\multirow{{{}}}{{*}}{{{}}}", rows, latex_text(page.name(cell.trajectory)));
    text += " & " + latex_text(page.name(cell.controller));
    if (cell.completed < cell.total) text += fmt::format(" ({})", completed_of(cell));
    for (const std::size_t metric : options.columns)
      text += " & " + latex_number(cell.errors[metric], page.is_best(cell, metric));
    text += ends ? " \\\\\n\\hline\n" : fmt::format(" \\\\\n\\cline{{{}-{}}}\n", leading + 1, all);
  }
  return text + "\\end{tabular}\n\\end{table*}\n";
}

std::string to_json(const Page& page) {
  nlohmann::ordered_json table{{"format", "gustlab-table/1"}, {"caption", page.caption()}, {"settle_s", page.settle_s}};
  table["cells"] = nlohmann::ordered_json::array();
  for (const TableCell& cell : page.cells) {
    nlohmann::ordered_json entry{{"experiment", cell.experiment}, {"vehicle", cell.vehicle},
                                 {"trajectory", cell.trajectory}, {"controller", cell.controller},
                                 {"completed", cell.completed},   {"total", cell.total}};
    for (const NamedValue& axis : cell.axes) entry["axes"][axis.name] = axis.value;
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i) {
      const Summary& error = cell.errors[i];
      entry[std::string(tracking_metrics[i].name)] = {
          {"mean", error.mean}, {"sd", error.sd}, {"median", error.median}, {"n", error.n}};
    }
    table["cells"].push_back(std::move(entry));
  }
  return config::json_text(table, 2) + "\n";
}

}  // namespace

std::optional<TableFormat> find_table_format(std::string_view name) {
  if (name == "md") return TableFormat::md;
  if (name == "csv") return TableFormat::csv;
  if (name == "latex") return TableFormat::latex;
  if (name == "json") return TableFormat::json;
  return std::nullopt;
}

std::optional<std::size_t> find_tracking_metric(std::string_view name) {
  if (name.empty()) return std::nullopt;
  for (std::size_t i = 0; i < tracking_metrics.size(); ++i)
    if (tracking_metrics[i].name.starts_with(name)) return i;
  return std::nullopt;
}

std::string completed_of(const TableCell& cell) {
  const std::size_t counted = cell.errors.front().n;
  return fmt::format("{}/{}", cell.completed, cell.total) +
         (counted < cell.total ? fmt::format(", n = {}", counted) : "");
}

bool is_better(const TableCell& cell, const TableCell& other, std::size_t metric) {
  const Summary &error = cell.errors[metric], &others = other.errors[metric];
  for (const auto& [runs, theirs] : {std::pair{cell.completed, other.completed}, {error.n, others.n}})
    if (runs * other.total != theirs * cell.total) return runs * other.total > theirs * cell.total;
  return error.mean < others.mean;
}

std::string without_variant(const std::string& experiment) { return experiment.substr(0, experiment.find('.')); }

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
      cells.push_back({row.experiment, row.vehicle, row.trajectory, row.controller, row.axes, 0, 0, {}});
      values.emplace_back();
    }
    ++cells[place].total;
    if (row.outcome == Outcome::completed) ++cells[place].completed;
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i)
      values[place][i].push_back(row.*tracking_metrics[i].value);
  }
  for (std::size_t place = 0; place < cells.size(); ++place)
    for (std::size_t i = 0; i < tracking_metrics.size(); ++i) cells[place].errors[i] = summarize(values[place][i]);
  return cells;
}

std::string runs_of_each(const std::vector<TableCell>& cells) {
  std::size_t fewest = cells.empty() ? 0 : cells.front().total, most = fewest;
  for (const TableCell& cell : cells) {
    fewest = std::min(fewest, cell.total);
    most = std::max(most, cell.total);
  }
  return fewest == most ? fmt::format("{}", most) : fmt::format("{} to {}", fewest, most);
}

std::string flown_in_words(const Results& results, const std::map<std::string, std::string>& names) {
  std::string flown;
  for (const NamedValue& arc : results.arcs)
    flown += fmt::format("{}{} {}", flown.empty() ? "" : "; ", named(arc.name, names), arc.value);
  return flown.empty() ? "" : fmt::format(" Flown: {}.", flown);
}

std::string to_table(const Results& results, const TableOptions& options) {
  const Page page(results, options);
  switch (options.format) {
    case TableFormat::md:
      return to_markdown(page, options);
    case TableFormat::csv:
      return to_csv(page, options);
    case TableFormat::latex:
      return to_latex(page, options);
    case TableFormat::json:
      return to_json(page);
  }
  return {};
}

}  // namespace gustlab
