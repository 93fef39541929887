#include "report/sweep_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>

#include "metrics/statistics.hpp"
#include "report/diagnosis_words.hpp"
#include "report/page_parts.hpp"
#include "report/svg.hpp"
#include "report/tables.hpp"

namespace gustlab {

namespace {

using namespace report;
using svg::escape;

constexpr std::size_t rmse = 0;  // of tracking_metrics

std::string metres(double value) { return std::isnan(value) ? "–" : fmt::format("{:.3f}", value); }

// decimals with which no spread of a column is written as 0.000, but for what rounding leaves of runs that are all alike
int digits_of(const std::vector<TableCell>& cells, std::size_t metric) {
  constexpr int most = 5;
  int digits = 3;
  for (const TableCell& cell : cells)
    if (const double sd = cell.errors[metric].sd; sd >= 0.5 * std::pow(10.0, -most))
      while (digits < most && sd < 0.5 * std::pow(10.0, -digits)) ++digits;
  return digits;
}

std::optional<double> number_of(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

// in the order in which they first appear
template <typename Items, typename Of>
std::vector<std::string> distinct(const Items& items, const Of& of) {
  std::vector<std::string> found;
  for (const auto& item : items)
    if (const std::string one = of(item); std::find(found.begin(), found.end(), one) == found.end())
      found.push_back(one);
  return found;
}

// as it is written beside a figure; empty where the sweep does not say
std::string unit_of(const Results& results, const std::string& axis) {
  for (const NamedValue& known : results.axis_units)
    if (known.name == axis) return known.value == "-" ? "–" : written_unit(known.value);
  return "";
}

// " N = 5 runs for each mean; 6 of 240 were not completed."
std::string runs_in_words(const std::vector<TableCell>& cells) {
  std::size_t total = 0, completed = 0, counted = 0;
  for (const TableCell& cell : cells) total += cell.total, completed += cell.completed, counted += cell.errors[rmse].n;
  std::string text = fmt::format(" N = {} runs for each mean", runs_of_each(cells));
  text +=
      completed == total ? ", all completed" : fmt::format("; {} of {} were not completed", total - completed, total);
  if (counted < total) text += fmt::format(", and {} without an error count in no mean", total - counted);
  return text + ".";
}

class Sweep {
 public:
  explicit Sweep(const Results& results) : results_(results), cells_(aggregate(results.rows)) {
    trajectories_ = distinct(cells_, [](const TableCell& cell) { return cell.trajectory; });
    controllers_ = distinct(cells_, [](const TableCell& cell) { return cell.controller; });
    for (const NamedValue& axis : cells_.front().axes) {
      const std::size_t place = axes_.size();
      axes_.push_back({axis.name, unit_of(results, axis.name),
                       distinct(cells_, [&](const TableCell& cell) { return cell.axes[place].value; })});
    }
  }

  std::string header() const;
  std::string table() const;
  std::string heat_maps() const;
  std::string over_axes() const;
  std::string failures() const;

 private:
  struct AxisValues {
    std::string name, unit;
    std::string title() const { return unit.empty() ? name : fmt::format("{} [{}]", name, unit); }
    std::string at(const std::string& value) const {
      return name + " = " + value + (unit.empty() || unit == "–" ? "" : " " + unit);
    }
    std::vector<std::string> values;
    bool numeric() const {
      return std::all_of(values.begin(), values.end(), [](const std::string& v) { return number_of(v).has_value(); });
    }
  };

  bool is_axis(std::size_t place) const { return axes_[place].values.size() > 1; }
  const TableCell* find(const std::string& trajectory, const std::string& controller,
                        const std::vector<std::string>& at) const {
    for (const TableCell& cell : cells_) {
      bool same = cell.trajectory == trajectory && cell.controller == controller;
      for (std::size_t a = 0; a < at.size(); ++a) same = same && cell.axes[a].value == at[a];
      if (same) return &cell;
    }
    return nullptr;
  }
  // the middle value of every axis
  std::vector<std::string> middle() const {
    std::vector<std::string> at;
    for (const AxisValues& axis : axes_) at.push_back(axis.values[axis.values.size() / 2]);
    return at;
  }
  // "mass = 0", of all axes but those that are drawn
  std::string others_at(const std::vector<std::string>& at, const std::vector<std::size_t>& drawn) const {
    std::vector<std::string> said;
    for (std::size_t a = 0; a < axes_.size(); ++a)
      if (is_axis(a) && std::find(drawn.begin(), drawn.end(), a) == drawn.end()) said.push_back(axes_[a].at(at[a]));
    return list_in_words(said);
  }
  // of the runs that ended before a sample counted
  std::string without_error() const {
    std::size_t without = 0;
    for (const TableCell& cell : cells_) without += cell.total - cell.errors[rmse].n;
    return without == 0 ? ""
                        : fmt::format(" {} ended before {:g} s and have none: means are over the n others.", without,
                                      results_.settle_s);
  }
  // what the caption of charts over an axis has to say
  struct Curves {
    std::vector<TableCell> cells;
    bool cut_at_zero = false, below_log = false;
  };
  std::string axis_chart(const std::string& trajectory, std::size_t axis, Curves& curves) const;

  const Results& results_;
  std::vector<TableCell> cells_;
  std::vector<std::string> trajectories_, controllers_;
  std::vector<AxisValues> axes_;
};

std::string Sweep::header() const {
  const auto runs = results_.rows.size();
  const auto failed =
      static_cast<std::size_t>(std::count_if(results_.rows.begin(), results_.rows.end(),
                                             [](const ResultRow& row) { return row.outcome != Outcome::completed; }));
  // who is best by is_better, trajectory by trajectory and point by point
  std::map<std::string, std::size_t> best;
  std::map<std::string, const TableCell*> least;
  for (const TableCell& cell : cells_) {
    std::string block = cell.experiment + "/" + cell.vehicle + "/" + cell.trajectory;
    for (const NamedValue& axis : cell.axes) block += "/" + axis.value;
    if (!std::isfinite(cell.errors[rmse].mean)) continue;
    const TableCell*& known = least[block];
    if (known == nullptr || is_better(cell, *known, rmse)) known = &cell;
  }
  for (const auto& [block, winner] : least) ++best[winner->controller];
  const auto most =
      std::max_element(best.begin(), best.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::string sentence = "No run has a sample that counts.";
  if (most != best.end() && controllers_.size() > 1)
    sentence = fmt::format("{} {} in {} of {} comparisons.", most->first,
                           failed == 0 ? "has the least mean RMSE" : "is best", most->second, least.size());
  else if (most != best.end()) sentence = fmt::format("{} over {} runs.", most->first, runs);
  std::string axes;
  for (std::size_t a = 0; a < axes_.size(); ++a)
    if (is_axis(a)) axes += fmt::format(" · {}: {} values", axes_[a].name, axes_[a].values.size());
  return fmt::format(
      "<header><p class=\"kind\">Sweep {} · {} · {} runs{}</p><h1>{}</h1>{}</header>",
      escape(without_variant(cells_.front().experiment)), escape(cells_.front().vehicle), runs, escape(axes),
      escape(sentence),
      paragraph(failed == 0
                    ? "Every run was completed."
                    : fmt::format(
                          "{} of {} runs were not completed; they keep their errors up to their end.{} Best: most runs "
                          "completed, then the least mean RMSE.",
                          failed, runs, without_error())));
}

std::string Sweep::table() const {
  std::vector<Column> columns;
  for (std::size_t a = 0; a < axes_.size(); ++a)
    if (is_axis(a)) columns.push_back({axes_[a].title()});
  columns.insert(columns.end(), {{"trajectory"}, {"controller"}, {"completed", true}});
  for (const Metric& metric : tracking_metrics) {
    columns.push_back({std::string(metric.title) + " [m]", true});
    if (&metric == &tracking_metrics[rmse]) columns.push_back({""});
  }
  std::string rows;
  double full = 0.0;
  for (const TableCell& cell : cells_)
    if (std::isfinite(cell.errors[rmse].mean)) full = std::max(full, cell.errors[rmse].mean);
  for (const TableCell& cell : cells_) {
    rows += "<tr>";
    for (std::size_t a = 0; a < axes_.size(); ++a)
      if (is_axis(a)) rows += fmt::format("<td>{}</td>", escape(cell.axes[a].value));
    rows += fmt::format("<td>{}</td><td class=\"name\">{}</td><td class=\"n\">{}</td>", escape(cell.trajectory),
                        escape(cell.controller), completed_of(cell));
    for (std::size_t m = 0; m < tracking_metrics.size(); ++m) {
      const Summary& error = cell.errors[m];
      const int digits = digits_of(cells_, m);
      rows += fmt::format("<td class=\"n\">{}{}</td>",
                          std::isnan(error.mean) ? "–" : fmt::format("{:.{}f}", error.mean, digits),
                          std::isnan(error.sd) ? "" : fmt::format(" ± {:.{}f}", error.sd, digits));
      if (m == rmse) rows += fmt::format("<td data-label=\"mean RMSE\">{}</td>", svg::bar(error.mean, NAN, full));
    }
    rows += "</tr>";
  }
  const std::string whole = card_table(columns, rows, " errors");
  const std::string note =
      paragraph(fmt::format("Distance to the reference, seen from above unless z is named, in "
                            "samples from {:g} s on: RMSE is the root of "
                            "its mean square, MAE its mean, 95 % of the samples are below P95. "
                            "Mean ± sample standard deviation over runs. "
                            "The bar is the mean RMSE.{}{}",
                            results_.settle_s, runs_in_words(cells_), escape(flown_in_words(results_))),
                "note");
  // what is drawn below need not be scrolled past
  return cells_.size() > 40
             ? note + fmt::format("<details><summary>All {} cells</summary>{}</details>", cells_.size(), whole)
             : note + whole;
}

// mean RMSE over two axes for each controller and trajectory, or over trajectories and controllers where there are none
std::string Sweep::heat_maps() const {
  std::vector<std::size_t> drawn;
  for (std::size_t a = 0; a < axes_.size() && drawn.size() < 2; ++a)
    if (is_axis(a)) drawn.push_back(a);
  double full = 0.0;
  bool any_failed = false;
  for (const TableCell& cell : cells_) {
    if (std::isfinite(cell.errors[rmse].mean)) full = std::max(full, cell.errors[rmse].mean);
    any_failed = any_failed || cell.completed < cell.total;
  }
  std::vector<TableCell> shown;
  const auto heat = [&](const TableCell* cell) -> std::string {
    if (!cell) return "<td></td>";
    shown.push_back(*cell);
    const double mean = cell->errors[rmse].mean;
    const std::string failed =
        cell->completed == cell->total ? "" : fmt::format(" <span class=\"soft\">{}</span>", completed_of(*cell));
    return fmt::format("<td style=\"--heat:{:.3f}\">{}{}</td>", std::isfinite(mean) && full > 0.0 ? mean / full : 0.0,
                       metres(mean), failed);
  };
  if (drawn.size() == 1) return "";  // lines show one axis better
  const auto map = [&](const std::string& title, const std::vector<std::string>& across, const std::string& corner,
                       const std::vector<std::string>& down, const auto& cell_at) {
    std::string html = fmt::format("<div><h3>{}</h3><div class=\"scroll\"><table class=\"heat\"><tr><th>{}</th>",
                                   escape(title), escape(corner));
    for (const std::string& value : across) html += fmt::format("<th class=\"n\">{}</th>", escape(value));
    html += "</tr>";
    for (const std::string& row : down) {
      html += fmt::format("<tr><th>{}</th>", escape(row));
      for (const std::string& column : across) html += heat(cell_at(row, column));
      html += "</tr>";
    }
    return html + "</table></div></div>";
  };
  std::vector<std::string> at = middle();
  std::string maps, note;
  if (drawn.empty()) {
    maps = map("", trajectories_, "", controllers_,
               [&](const std::string& row, const std::string& column) { return find(column, row, at); });
  } else {
    for (const std::string& trajectory : trajectories_)
      for (const std::string& controller : controllers_)
        maps += map(controller + ", " + trajectory, axes_[drawn[0]].values,
                    axes_[drawn[1]].title() + " \\ " + axes_[drawn[0]].title(), axes_[drawn[1]].values,
                    [&](const std::string& row, const std::string& column) {
                      std::vector<std::string> here = at;
                      here[drawn[0]] = column, here[drawn[1]] = row;
                      return find(trajectory, controller, here);
                    });
    if (const std::string others = others_at(at, drawn); !others.empty()) note = " Shown at " + others + ".";
  }
  return paragraph(
             "Mean RMSE in m; the stronger the colour, the larger." + runs_in_words(shown) +
                 std::string(any_failed ? " Small figures say how many runs were completed, where not all were." : "") +
                 note,
             "note") +
         "<div class=\"charts\">" + maps + "</div>";
}

std::string Sweep::axis_chart(const std::string& trajectory, std::size_t axis, Curves& curves) const {
  svg::Chart chart;
  bool reaches_zero = false;
  chart.title = trajectory;
  chart.x_label = axes_[axis].title();
  chart.y_label = "RMSE [m]";
  std::vector<std::string> at = middle();
  for (std::size_t c = 0; c < controllers_.size(); ++c) {
    svg::Series series;
    series.style = series_style(c);
    series.mark = svg::Mark::points_with_bars;
    std::vector<std::pair<double, const TableCell*>> points;
    for (const std::string& value : axes_[axis].values) {
      at[axis] = value;
      if (const TableCell* cell = find(trajectory, controllers_[c], at)) points.emplace_back(*number_of(value), cell);
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [x, cell] : points) {
      const Summary& error = cell->errors[rmse];
      const Interval interval = error.n > 1 ? mean_interval(error, 0.95) : Interval{error.mean, error.mean};
      series.x.push_back(x);
      series.y.push_back(error.mean);
      series.low.push_back(std::max(interval.low, 0.0));  // no error is less
      series.high.push_back(interval.high);
      reaches_zero = reaches_zero || interval.low < 0.0;
      curves.cells.push_back(*cell);
    }
    chart.series.push_back(std::move(series));
  }
  // over decades, a line along the bottom would say nothing of the small errors
  double least = INFINITY, most = 0.0;
  for (const svg::Series& series : chart.series)
    for (const double mean : series.y)
      if (mean > 0.0) least = std::min(least, mean), most = std::max(most, mean);
  chart.log_y = most > 10.0 * least;
  chart.zero_y = !chart.log_y;
  (chart.log_y ? curves.below_log : curves.cut_at_zero) |= reaches_zero;
  return svg::draw(chart);
}

std::string Sweep::over_axes() const {
  std::string html;
  std::vector<std::pair<std::string, std::string>> entries;
  for (std::size_t c = 0; c < controllers_.size(); ++c) entries.emplace_back(series_style(c), controllers_[c]);
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (!is_axis(a) || !axes_[a].numeric()) continue;
    std::string charts;
    Curves curves;
    for (const std::string& trajectory : trajectories_) charts += axis_chart(trajectory, a, curves);
    if (charts.empty()) continue;
    const std::string others = others_at(middle(), {a});
    html += fmt::format(
        "<figure><h3>Over {}</h3>{}<div class=\"charts\">{}</div><figcaption>Mean RMSE; bars: 95 % intervals of "
        "the mean{}.{}{}{}</figcaption></figure>",
        escape(axes_[a].name), legend(entries), charts,
        curves.cut_at_zero ? ", cut off at 0 because no error is less" : "",
        curves.below_log ? " On a log scale, which has no 0, a bar that reaches 0 ends at the lower edge." : "",
        runs_in_words(curves.cells), others.empty() ? "" : escape(" Shown at " + others + "."));
  }
  return html;
}

std::string Sweep::failures() const {
  struct Failed {
    std::string where, controller, outcome;
    std::size_t count = 0, of = 0;
    double earliest_s = INFINITY;
    std::int64_t replicate = 0;
  };
  std::vector<Failed> found;
  for (const ResultRow& row : results_.rows) {
    if (row.outcome == Outcome::completed) continue;
    std::string where = row.trajectory;
    for (std::size_t a = 0; a < row.axes.size(); ++a)
      if (is_axis(a)) where += ", " + axes_[a].at(row.axes[a].value);
    const std::string outcome(to_string(row.outcome));
    auto known = std::find_if(found.begin(), found.end(), [&](const Failed& one) {
      return one.where == where && one.controller == row.controller && one.outcome == outcome;
    });
    if (known == found.end()) known = found.insert(found.end(), {where, row.controller, outcome, 0, 0, INFINITY, 0});
    ++known->count;
    if (row.duration_s < known->earliest_s) known->earliest_s = row.duration_s, known->replicate = row.replicate;
    for (const TableCell& cell : cells_)
      if (cell.experiment == row.experiment && cell.trajectory == row.trajectory && cell.controller == row.controller)
        known->of = cell.total;
  }
  if (found.empty()) return "";
  std::string rows;
  for (const Failed& one : found)
    rows += fmt::format(
        "<tr><td class=\"name\">{}</td><td>{}</td><td>{}</td><td class=\"n\">{} of {}</td><td class=\"n\">{:.2f} s, "
        "replicate "
        "{}</td></tr>",
        escape(one.where), escape(one.controller), escape(plain_label(one.outcome)), one.count, one.of, one.earliest_s,
        one.replicate);
  return card_table({{"where"}, {"controller"}, {"how it ended"}, {"runs", true}, {"the earliest", true}}, rows);
}

std::string paths(const SweepFigures& figures) {
  const auto trajectories = distinct(figures.paths, [](const SweptPath& path) { return path.trajectory; });
  const auto controllers = distinct(figures.paths, [](const SweptPath& path) { return path.controller; });
  std::string charts;
  for (const std::string& trajectory : trajectories) {
    svg::Chart chart;
    chart.title = trajectory;
    chart.x_label = "x [m]";
    chart.y_label = "y [m]";
    chart.equal_scales = true;
    for (const SweptPath& path : figures.paths) {
      if (path.trajectory != trajectory) continue;
      if (chart.series.empty())
        chart.series.push_back({"reference", svg::Mark::line, path.reference_x_m, path.reference_y_m, {}, {}});
      const auto n = static_cast<std::size_t>(std::find(controllers.begin(), controllers.end(), path.controller) -
                                              controllers.begin());
      chart.series.push_back({series_style(n), svg::Mark::line, path.x_m, path.y_m, {}, {}});
    }
    charts += svg::draw(chart);
  }
  if (charts.empty())
    return paragraph(
        "No flight log is in the folder of the sweep. gustlab sweep --logs writes them, and the paths are drawn here.",
        "note");
  std::vector<std::pair<std::string, std::string>> entries{{"reference", "reference"}};
  for (std::size_t c = 0; c < controllers.size(); ++c) entries.emplace_back(series_style(c), controllers[c]);
  return "<figure>" + legend(entries) + "<div class=\"charts\">" + charts + "</div><figcaption>From above. " +
         escape(figures.paths_of) + "</figcaption></figure>";
}

}  // namespace

std::string sweep_page(const Results& results, const SweepFigures& figures) {
  const Sweep sweep(results);
  std::string body;
  for (const std::string& piece :
       {sweep.header(), section("Errors", sweep.table()), section("Heat map", sweep.heat_maps()),
        section("Error over what was varied", sweep.over_axes()), section("Paths", paths(figures)),
        section("What was not completed", sweep.failures())})
    if (!piece.empty()) body += piece + "\n";
  return page("Sweep " + without_variant(results.rows.front().experiment), body);
}

}  // namespace gustlab
