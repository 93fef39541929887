#include "report/reproduction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "config/json_text.hpp"
#include "gustlab/random.hpp"
#include "report/claims.hpp"
#include "report/svg.hpp"
#include "util/quantiles.hpp"

namespace gustlab {

namespace {

// the published figures have three decimals
constexpr double rounding_m = 0.001;

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

DrawnTables::Count count_of(const std::vector<double>& within) {
  return {summarize(within).mean, quantile(within, 0.1), quantile(within, 0.9)};
}

// with replacement, one draw of gusts for all cells. runs: of each cell, by replicate
DrawnTables draw_tables(const std::vector<ReproducedCell>& cells, const std::vector<std::vector<double>>& runs) {
  constexpr std::uint32_t tables = 10000;
  const RandomStream stream(1, 0, "drawn tables");
  std::vector<double> drawn(cells.front().paper.n), within_25(tables), within_50(tables);
  for (std::uint32_t table = 0; table < tables; ++table)
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for (std::size_t run = 0; run < drawn.size(); ++run)
        drawn[run] =
            runs[i][static_cast<std::size_t>(stream.uniform4(run, table)[0] * static_cast<double>(runs[i].size()))];
      ReproducedCell cell = cells[i];
      cell.ours = summarize(drawn);
      within_25[table] += cell.within(0.25);
      within_50[table] += cell.within(0.50);
    }
  return {cells.front().table, runs.front().size(), drawn.size(), count_of(within_25), count_of(within_50)};
}

nlohmann::ordered_json to_json(const DrawnTables::Count& count) {
  return {{"expected", count.expected}, {"low", count.low}, {"high", count.high}};
}

// of the style sheet
std::string class_of(Use use) {
  std::string name(to_string(use));
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

// how many runs stand behind means, over cells
std::string runs_text(const std::vector<ReproducedCell>& cells, Summary ReproducedCell::*side) {
  if (cells.empty()) return "no runs";
  const auto [least, most] = std::minmax_element(
      cells.begin(), cells.end(), [&](const auto& a, const auto& b) { return (a.*side).n < (b.*side).n; });
  const std::size_t low = (*least.*side).n, high = (*most.*side).n;
  return low == high ? fmt::format("N = {} runs", low) : fmt::format("N = {} to {} runs", low, high);
}

}  // namespace

std::string_view to_string(Use use) {
  switch (use) {
    case Use::fitted:
      return "fitted";
    case Use::blind:
      return "predicted blind";
    case Use::by_construction:
      return "by construction";
    case Use::after_seeing:
      return "chosen after seeing";
    case Use::proxy:
      return "proxy";
  }
  return "";
}

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::not_significant:
      return "not_significant";
  }
  return "";
}

double ReproducedCell::z_score() const {
  const double se_ours = ours.sd * ours.sd / static_cast<double>(ours.n),
               se_paper = paper.sd * paper.sd / static_cast<double>(paper.n);
  return (ours.mean - paper.mean) / std::sqrt(se_ours + se_paper + rounding_m * rounding_m / 12.0);
}

bool ReproducedCell::within_spread() const { return std::abs(ours.mean - paper.mean) <= paper.sd + 0.5 * rounding_m; }

namespace {

// as docs/FORMATS.md has it
std::string_view use_in_short(Use use) {
  return use == Use::fitted || use == Use::proxy ? to_string(use) : std::string_view("predicted");
}

// the cells of the paper that a table of ours flew in still air, and its claims judged there
void add_still_air(const Published& published, const std::vector<OurTable>& tables, Reproduction& reproduction) {
  std::vector<OurTable> still = tables;
  for (OurTable& table : still) table.rows = table.still;
  if (std::any_of(still.begin(), still.end(), [](const OurTable& table) { return table.rows.empty(); })) return;
  std::vector<ReproducedCell> cells = reproduction.cells;
  for (ReproducedCell& cell : cells) {
    const auto table =
        std::find_if(still.begin(), still.end(), [&](const OurTable& t) { return t.table == cell.table; });
    cell.ours = summarize(metric_of(counted_runs(published, *table, cell.trajectory, cell.controller), cell.metric));
  }
  for (std::size_t i = 0; i < cells.size(); ++i) reproduction.cells[i].still_m = cells[i].ours.mean;
  const std::vector<JudgedClaim> judged = judge_claims(published, still, cells);
  for (std::size_t i = 0; i < judged.size(); ++i) reproduction.claims[i].still = judged[i].verdict;
}

}  // namespace

Reproduction reproduce(const Published& published, const std::vector<OurTable>& tables,
                       const std::function<Use(const PublishedRow&, std::size_t metric)>& use) {
  Reproduction reproduction;
  for (const OurTable& table : tables) {
    std::vector<ReproducedCell> cells;
    std::vector<std::vector<double>> values;  // of each cell, by replicate
    for (const PublishedRow& row : published.rows) {
      if (row.table != table.table) continue;
      const std::vector<ResultRow> runs = counted_runs(published, table, row.trajectory, row.controller);
      if (runs.empty()) continue;
      std::size_t completed = 0;
      for (const ResultRow& run : runs) completed += run.outcome == Outcome::completed;
      for (std::size_t metric = 0; metric < published_metrics.size(); ++metric) {
        values.push_back(metric_of(runs, metric));
        cells.push_back({table.table, table.vehicle, row.trajectory, row.controller, metric, row.figures[metric],
                         summarize(values.back()), completed, use(row, metric)});
      }
    }
    if (!cells.empty() && values.front().size() > cells.front().paper.n)
      reproduction.drawn.push_back(draw_tables(cells, values));
    reproduction.cells.insert(reproduction.cells.end(), cells.begin(), cells.end());
  }
  reproduction.claims = judge_claims(published, tables, reproduction.cells);
  add_still_air(published, tables, reproduction);
  return reproduction;
}

std::string to_json(const Reproduction& reproduction) {
  nlohmann::ordered_json json{{"format", "gustlab-reproduction/1"}};
  std::size_t within_25 = 0, within_50 = 0;
  json["cells"] = nlohmann::ordered_json::array();
  for (const ReproducedCell& cell : reproduction.cells) {
    within_25 += cell.within(0.25);
    within_50 += cell.within(0.50);
    json["cells"].push_back({{"table", cell.table},
                             {"vehicle", cell.vehicle},
                             {"trajectory", cell.trajectory},
                             {"controller", cell.controller},
                             {"metric", published_metrics[cell.metric]},
                             {"paper_mean", cell.paper.mean},
                             {"paper_sd", cell.paper.sd},
                             {"ours_mean", number(cell.ours.mean)},
                             {"ours_sd", number(cell.ours.sd)},
                             {"n", cell.ours.n},
                             {"completed", cell.completed},
                             {"still_air_mean", number(cell.still_m)},
                             {"gust_share", number(cell.gust_share())},
                             {"use", use_in_short(cell.use)},
                             {"provenance", to_string(cell.use)},
                             {"ratio", number(cell.ratio())},
                             {"z_score", number(cell.z_score())},
                             {"within_paper_sd", cell.within_spread()}});
  }
  for (const DrawnTables& drawn : reproduction.drawn)
    json["drawn_tables"].push_back({{"table", drawn.table},
                                    {"gusts", drawn.gusts},
                                    {"runs", drawn.runs},
                                    {"within_25_percent", to_json(drawn.within_25)},
                                    {"within_50_percent", to_json(drawn.within_50)}});
  json["claims"] = nlohmann::ordered_json::array();
  for (const JudgedClaim& claim : reproduction.claims)
    json["claims"].push_back(
        {{"claim", claim.table + ": " + claim.claim},
         {"verdict", to_string(claim.verdict)},
         {"p_value", number(claim.p_value)},
         {"n", claim.n},
         {"paper_p_value", number(claim.paper_p_value)},
         {"still_air", claim.still ? nlohmann::ordered_json(to_string(*claim.still)) : nlohmann::ordered_json(nullptr)},
         {"needs_gust", claim.needs_gust()}});
  json["counts"] = {
      {"cells", reproduction.cells.size()}, {"within_25_percent", within_25}, {"within_50_percent", within_50}};
  return config::json_text(json, 2) + "\n";
}

std::string to_svg(const Reproduction& reproduction) {
  svg::Chart chart;
  chart.title = "Mean errors, ours and the paper's; lines: ±25 %";
  chart.x_label = fmt::format("paper, m, {}", runs_text(reproduction.cells, &ReproducedCell::paper));
  chart.y_label = fmt::format(
      "ours, m, {}: blue fitted, orange predicted blind, green by construction, red chosen after seeing, grey proxy",
      runs_text(reproduction.cells, &ReproducedCell::ours));
  chart.log_x = chart.log_y = true;
  chart.width = 720.0;
  chart.height = 480.0;
  double low = 1e9, high = 0.0;
  for (const ReproducedCell& cell : reproduction.cells) {
    low = std::min(low, cell.paper.mean);
    high = std::max(high, cell.paper.mean);
  }
  for (const double factor : {0.75, 1.0, 1.25})
    chart.series.push_back(
        {factor == 1.0 ? "equal" : "band", svg::Mark::line, {low, high}, {factor * low, factor * high}, {}, {}});
  for (const Use use : all_uses) {
    svg::Series series{class_of(use), svg::Mark::dots, {}, {}, {}, {}};
    for (const ReproducedCell& cell : reproduction.cells)
      if (cell.use == use) {
        series.x.push_back(cell.paper.mean);
        series.y.push_back(cell.ours.mean);
      }
    chart.series.push_back(std::move(series));
  }
  std::string text = svg::draw(chart);
  const std::size_t open = text.find('>');
  if (open == std::string::npos) return text;
  // alone, a picture brings its own style
  text.insert(
      open + 1,
      "<style>text{font:11px sans-serif;fill:#333}.head{font-weight:bold}.grid{stroke:#ddd}.axis,.tick{stroke:#666}"
      "path{fill:none}.equal{stroke:#333}.band{stroke:#999;stroke-dasharray:4 "
      "3}circle{stroke:none}.fitted{fill:#1f77b4}"
      ".predicted-blind{fill:#ff7f0e}.by-construction{fill:#2ca02c}.chosen-after-seeing{fill:#d62728}.proxy{fill:#888}<"
      "/style>");
  text.insert(4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return text + "\n";
}

}  // namespace gustlab
