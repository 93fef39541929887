#include "report/reproduction.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/claims.hpp"
#include "report/svg.hpp"

namespace gustlab {

namespace {

// the published figures have three decimals
constexpr double rounding_m = 0.001;

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::string_view to_string(Use use) {
  switch (use) {
    case Use::fitted: return "fitted";
    case Use::predicted: return "predicted";
    case Use::proxy: return "proxy";
  }
  return "";
}

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass: return "pass";
    case Verdict::fail: return "fail";
    case Verdict::not_significant: return "not_significant";
  }
  return "";
}

double ReproducedCell::z_score() const {
  const double se_ours = ours.sd * ours.sd / static_cast<double>(ours.n), se_paper = paper.sd * paper.sd / static_cast<double>(paper.n);
  return (ours.mean - paper.mean) / std::sqrt(se_ours + se_paper + rounding_m * rounding_m / 12.0);
}

bool ReproducedCell::within_spread() const { return std::abs(ours.mean - paper.mean) <= paper.sd + 0.5 * rounding_m; }

Reproduction reproduce(const Published& published, const std::vector<OurTable>& tables,
                       const std::function<Use(const PublishedRow&, std::size_t metric)>& use) {
  Reproduction reproduction;
  for (const OurTable& table : tables)
    for (const PublishedRow& row : published.rows) {
      if (row.table != table.table) continue;
      const std::vector<ResultRow> runs = counted_runs(published, table, row.trajectory, row.controller);
      if (runs.empty()) continue;
      std::size_t completed = 0;
      for (const ResultRow& run : runs) completed += run.outcome == Outcome::completed;
      for (std::size_t metric = 0; metric < published_metrics.size(); ++metric)
        reproduction.cells.push_back({table.table, table.vehicle, row.trajectory, row.controller, metric, row.figures[metric],
                                      summarize(metric_of(runs, metric)), completed, use(row, metric)});
    }
  reproduction.claims = judge_claims(published, tables, reproduction.cells);
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
                             {"use", to_string(cell.use)},
                             {"ratio", number(cell.ratio())},
                             {"z_score", number(cell.z_score())},
                             {"within_paper_sd", cell.within_spread()}});
  }
  json["claims"] = nlohmann::ordered_json::array();
  for (const JudgedClaim& claim : reproduction.claims)
    json["claims"].push_back({{"claim", claim.table + ": " + claim.claim},
                              {"verdict", to_string(claim.verdict)},
                              {"p_value", number(claim.p_value)},
                              {"n", claim.n},
                              {"paper_p_value", number(claim.paper_p_value)}});
  json["counts"] = {{"cells", reproduction.cells.size()}, {"within_25_percent", within_25}, {"within_50_percent", within_50}};
  return json.dump(2) + "\n";
}

std::string to_svg(const Reproduction& reproduction) {
  svg::Chart chart;
  chart.title = "Mean errors, ours and the paper's; lines: ±25 %";
  chart.x_label = "paper, m";
  chart.y_label = "ours, m: blue fitted, orange predicted, grey proxy";
  chart.log_x = chart.log_y = true;
  chart.width = 640.0;
  chart.height = 480.0;
  double low = 1e9, high = 0.0;
  for (const ReproducedCell& cell : reproduction.cells) {
    low = std::min(low, cell.paper.mean);
    high = std::max(high, cell.paper.mean);
  }
  for (const double factor : {0.75, 1.0, 1.25})
    chart.series.push_back({factor == 1.0 ? "equal" : "band", svg::Mark::line, {low, high}, {factor * low, factor * high}, {}, {}});
  for (const Use use : {Use::fitted, Use::predicted, Use::proxy}) {
    svg::Series series{std::string(to_string(use)), svg::Mark::dots, {}, {}, {}, {}};
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
  text.insert(open + 1,
              "<style>text{font:11px sans-serif;fill:#333}.head{font-weight:bold}.grid{stroke:#ddd}.axis,.tick{stroke:#666}"
              "path{fill:none}.equal{stroke:#333}.band{stroke:#999;stroke-dasharray:4 3}circle{stroke:none}.fitted{fill:#1f77b4}"
              ".predicted{fill:#ff7f0e}.proxy{fill:#888}</style>");
  text.insert(4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return text + "\n";
}

}  // namespace gustlab
