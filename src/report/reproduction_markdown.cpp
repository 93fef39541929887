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
  return fmt::format("| {} | {} | {} | {} | {} | {} of {} | {} |\n", name, cells.size(),
                     count(cells, [](const auto& c) { return c.within(0.25); }),
                     count(cells, [](const auto& c) { return c.within(0.50); }),
                     count(cells, [](const auto& c) { return c.within_spread(); }),
                     count(cells, [](const auto& c) { return c.has_spread() && c.spread_within(2.0); }),
                     count(cells, [](const auto& c) { return c.has_spread(); }),
                     count(cells, [](const auto& c) { return std::abs(c.still_m / c.paper.mean - 1.0) <= 0.25; }));
}

std::string counts(const Reproduction& reproduction, const std::vector<OurTable>& tables) {
  std::string text =
      "| cells | all | within ±25 % | within ±50 % | within one sd of the paper | sd within a factor of 2 | within ±25 "
      "% in still air |\n"
      "|---|--:|--:|--:|--:|--:|--:|\n";
  const auto subset = [&](auto is) {
    std::vector<ReproducedCell> cells;
    for (const ReproducedCell& cell : reproduction.cells)
      if (is(cell)) cells.push_back(cell);
    return cells;
  };
  for (const OurTable& table : tables)
    text += count_line(table.experiment, subset([&](const auto& c) { return c.table == table.table; }));
  for (const Use use : all_uses)
    text += count_line(to_string(use), subset([&](const auto& c) { return c.use == use; }));
  return text + count_line("all", reproduction.cells);
}

std::string drawn_counts(const std::vector<DrawnTables>& all) {
  if (all.empty()) return "";
  std::string text =
      "| tables drawn from ours | expected within ±25 % | 10 to 90 % | expected within ±50 % | 10 to 90 % "
      "|\n|---|--:|--:|--:|--:|\n";
  for (const DrawnTables& drawn : all)
    text += fmt::format("| {}: {} of {} gusts | {:.1f} | {} to {} | {:.1f} | {} to {} |\n", drawn.table, drawn.runs,
                        drawn.gusts, drawn.within_25.expected, drawn.within_25.low, drawn.within_25.high,
                        drawn.within_50.expected, drawn.within_50.low, drawn.within_50.high);
  return text + "\n";
}

std::string verdict_line(std::string_view name, const std::vector<JudgedClaim>& claims, bool significant_only) {
  std::array<std::size_t, 3> verdicts{};
  std::size_t all = 0, need_gust = 0;
  for (const JudgedClaim& claim : claims) {
    if (significant_only && !(claim.paper_p_value < 0.05)) continue;
    ++all;
    ++verdicts[static_cast<std::size_t>(claim.verdict)];
    need_gust += claim.needs_gust();
  }
  return fmt::format("| {} {} | {} | {} | {} | {} |\n", name, all, verdicts[0], need_gust, verdicts[1], verdicts[2]);
}

std::string verdict_counts(const std::vector<JudgedClaim>& claims) {
  return "| claims | pass | of these, need the gust | fail | not significant |\n|---|--:|--:|--:|--:|\n" +
         verdict_line("all", claims, false) +
         verdict_line("significant by the paper's own figures (Welch, p < 0.05):", claims, true);
}

// mean in still air, and the share of the mean error that is gone there
std::string still_text(const ReproducedCell& cell) {
  return std::isnan(cell.still_m) ? "– | –" : fmt::format("{:.3f} | {:.0f} %", cell.still_m, 100.0 * cell.gust_share());
}

std::string_view verdict_text(Verdict verdict) {
  return verdict == Verdict::not_significant ? "not significant" : to_string(verdict);
}

std::string cell_table(const std::vector<ReproducedCell>& cells, const std::string& table) {
  std::string text =
      "| trajectory | controller | metric | paper | ours | still air | by the gust | ratio | z | in the paper's spread "
      "| completed | use |\n"
      "|---|---|---|--:|--:|--:|--:|--:|--:|---|--:|---|\n";
  for (const ReproducedCell& cell : cells)
    if (cell.table == table)
      text += fmt::format(
          "| {} | {} | {} | {:.3f} ± {:.3f} | {:.3f} ± {:.3f} | {} | {:.2f} | {:+.1f} | {} | {}/{} | {} |\n",
          cell.trajectory, cell.controller, tracking_metrics[cell.metric].title, cell.paper.mean, cell.paper.sd,
          cell.ours.mean, cell.ours.sd, still_text(cell), cell.ratio(), cell.z_score(),
          cell.within_spread() ? "yes" : "no", cell.completed, cell.ours.n, to_string(cell.use));
  return text;
}

std::string claim_table(const std::vector<JudgedClaim>& claims) {
  std::string text =
      "| table | claim | verdict | p | n | the paper's own p | in still air | needs the gust "
      "|\n|---|---|---|--:|--:|--:|---|---|\n";
  for (const JudgedClaim& claim : claims)
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} |\n", claim.table, claim.claim,
                        verdict_text(claim.verdict), p_text(claim.p_value), claim.n, p_text(claim.paper_p_value),
                        claim.still ? verdict_text(*claim.still) : "–",
                        claim.verdict != Verdict::pass || !claim.still ? "–"
                        : claim.needs_gust()                           ? "yes"
                                                                       : "no");
  return text;
}

// how much of each trajectory was flown
std::string flown_text(const OurTable& table) {
  std::string text;
  for (const NamedValue& arc : table.arcs)
    text += fmt::format("{}{} {}", text.empty() ? "Flown: " : "; ", arc.name, arc.value);
  return text.empty() ? "" : text + ".\n\n";
}

}  // namespace

std::string to_markdown(const Reproduction& reproduction, const std::vector<OurTable>& tables) {
  std::string text =
      "# Our tables beside the paper's (arXiv 2603.08863)\n\nWritten by `gustlab reproduce`. Planar tracking errors in "
      "m, mean ± "
      "sample standard deviation over runs; still air is our mean without any "
      "wind, by the gust what is then gone of it; ratio is ours over the paper's, z the difference over both standard "
      "errors. Fitted "
      "cells were calibrated on, with other seeds. Of the others, those that are so by construction, and those that a "
      "choice stands "
      "behind which was made when they had been seen, are told apart from those predicted blind. Proxy cells simulate "
      "what the paper "
      "flew for real.\n\n";
  text += counts(reproduction, tables) + "\n" + drawn_counts(reproduction.drawn) + verdict_counts(reproduction.claims);
  for (const OurTable& table : tables)
    text += fmt::format("\n## {}: {}\n\n", table.table, table.experiment) + flown_text(table) +
            cell_table(reproduction.cells, table.table);
  text +=
      "\n## Claims\n\npass: our flights show it, p < 0.05; fail: they show the opposite, p < 0.05. Paired by gust "
      "within a trajectory, Welch "
      "across; a claim over many cells has the p of its weakest, – where nothing scatters; nothing is corrected for "
      "the number of claims. In still air the "
      "same claim is judged without any wind; it needs the gust when it passes in gusts only.\n\n";
  return text + claim_table(reproduction.claims);
}

}  // namespace gustlab
