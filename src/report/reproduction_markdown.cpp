#include <fmt/format.h>

#include <array>
#include <cmath>

#include "report/reproduction.hpp"
#include "report/tables.hpp"

namespace gustlab {

namespace {

template <class Predicate>
std::size_t count(const std::vector<ReproducedCell>& cells, Predicate is) {
  return static_cast<std::size_t>(std::count_if(cells.begin(), cells.end(), is));
}

std::string p_text(double p) {
  if (std::isnan(p)) return "–";
  return p < 0.001 ? "< 0.001" : fmt::format("{:.3f}", p);
}

std::string count_line(std::string_view name, const std::vector<ReproducedCell>& cells) {
  if (cells.empty()) return "";
  return fmt::format("| {} | {} | {} | {} | {} |\n", name, cells.size(), count(cells, [](const auto& c) { return c.within(0.25); }),
                     count(cells, [](const auto& c) { return c.within(0.50); }), count(cells, [](const auto& c) { return c.within_spread(); }));
}

std::string counts(const Reproduction& reproduction, const std::vector<OurTable>& tables) {
  std::string text = "| cells | all | within ±25 % | within ±50 % | within one sd of the paper |\n|---|--:|--:|--:|--:|\n";
  const auto subset = [&](auto is) {
    std::vector<ReproducedCell> cells;
    for (const ReproducedCell& cell : reproduction.cells)
      if (is(cell)) cells.push_back(cell);
    return cells;
  };
  for (const OurTable& table : tables) text += count_line(table.experiment, subset([&](const auto& c) { return c.table == table.table; }));
  for (const Use use : {Use::fitted, Use::predicted, Use::proxy}) text += count_line(to_string(use), subset([&](const auto& c) { return c.use == use; }));
  return text + count_line("all", reproduction.cells);
}

std::string drawn_counts(const std::vector<DrawnTables>& all) {
  if (all.empty()) return "";
  std::string text = "| tables drawn from ours | expected within ±25 % | 10 to 90 % | expected within ±50 % | 10 to 90 % |\n|---|--:|--:|--:|--:|\n";
  for (const DrawnTables& drawn : all)
    text += fmt::format("| {}: {} of {} gusts | {:.1f} | {} to {} | {:.1f} | {} to {} |\n", drawn.table, drawn.runs, drawn.gusts, drawn.within_25.expected,
                        drawn.within_25.low, drawn.within_25.high, drawn.within_50.expected, drawn.within_50.low, drawn.within_50.high);
  return text + "\n";
}

std::string verdict_counts(const std::vector<JudgedClaim>& claims) {
  std::array<std::array<std::size_t, 3>, 2> verdicts{};
  for (const JudgedClaim& claim : claims) {
    ++verdicts[0][static_cast<std::size_t>(claim.verdict)];
    if (claim.paper_p_value < 0.05) ++verdicts[1][static_cast<std::size_t>(claim.verdict)];
  }
  std::string text = "| claims | pass | fail | not significant |\n|---|--:|--:|--:|\n";
  text += fmt::format("| all {} | {} | {} | {} |\n", claims.size(), verdicts[0][0], verdicts[0][1], verdicts[0][2]);
  text += fmt::format("| significant by the paper's own figures (Welch, p < 0.05) | {} | {} | {} |\n", verdicts[1][0], verdicts[1][1], verdicts[1][2]);
  return text;
}

std::string cell_table(const std::vector<ReproducedCell>& cells, const std::string& table) {
  std::string text = "| trajectory | controller | metric | paper | ours | ratio | z | in the paper's spread | completed | use |\n"
                     "|---|---|---|--:|--:|--:|--:|---|--:|---|\n";
  for (const ReproducedCell& cell : cells)
    if (cell.table == table)
      text += fmt::format("| {} | {} | {} | {:.3f} ± {:.3f} | {:.3f} ± {:.3f} | {:.2f} | {:+.1f} | {} | {}/{} | {} |\n", cell.trajectory,
                          cell.controller, tracking_metrics[cell.metric].title, cell.paper.mean, cell.paper.sd, cell.ours.mean, cell.ours.sd,
                          cell.ratio(), cell.z_score(), cell.within_spread() ? "yes" : "no", cell.completed, cell.ours.n, to_string(cell.use));
  return text;
}

std::string claim_table(const std::vector<JudgedClaim>& claims) {
  std::string text = "| table | claim | verdict | p | n | the paper's own p |\n|---|---|---|--:|--:|--:|\n";
  for (const JudgedClaim& claim : claims)
    text += fmt::format("| {} | {} | {} | {} | {} | {} |\n", claim.table, claim.claim,
                        claim.verdict == Verdict::not_significant ? "not significant" : to_string(claim.verdict), p_text(claim.p_value),
                        claim.n, p_text(claim.paper_p_value));
  return text;
}

}  // namespace

std::string to_markdown(const Reproduction& reproduction, const std::vector<OurTable>& tables) {
  std::string text = "# Our tables beside the paper's (arXiv 2603.08863)\n\nWritten by `gustlab reproduce`. Planar tracking errors in m, mean ± "
                     "sample standard deviation over runs; ratio is ours over the paper's, z the difference over both standard errors. Fitted "
                     "cells were calibrated on, with other seeds; predicted ones were not; proxy ones simulate what the paper flew for real.\n\n";
  text += counts(reproduction, tables) + "\n" + drawn_counts(reproduction.drawn) + verdict_counts(reproduction.claims);
  for (const OurTable& table : tables)
    text += fmt::format("\n## {}: {}\n\n", table.table, table.experiment) + cell_table(reproduction.cells, table.table);
  text += "\n## Claims\n\npass: our flights show it, p < 0.05; fail: they show the opposite, p < 0.05. Paired by gust within a trajectory, Welch "
          "across; a claim over many cells has the p of its weakest; nothing is corrected for the number of claims.\n\n";
  return text + claim_table(reproduction.claims);
}

}  // namespace gustlab
