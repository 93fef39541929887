// Our tables beside the paper's: every published mean with ours, and every claim judged.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/published.hpp"
#include "sweep/results.hpp"

namespace gustlab {

// How a cell of ours came to be: calibrated on (on other seeds), predicted and seen by no choice of ours, so by construction, after
// a choice that was made when the cell had been seen, or in a simulation that only stands for the real thing.
enum class Use { fitted, blind, by_construction, after_seeing, proxy };
inline constexpr std::array<Use, 5> all_uses{Use::fitted, Use::blind, Use::by_construction, Use::after_seeing,
                                             Use::proxy};
std::string_view to_string(Use use);

struct ReproducedCell {
  std::string table, vehicle, trajectory, controller;
  std::size_t metric = 0;  // of published_metrics
  Summary paper, ours;
  std::size_t completed = 0;
  Use use = Use::blind;
  double still_m = std::numeric_limits<double>::quiet_NaN();  // our mean without any wind; NaN: not flown

  // of the mean error, what is gone in still air
  double gust_share() const { return 1.0 - still_m / ours.mean; }
  // the published one is told with three digits behind the point: none where that is zero
  bool has_spread() const { return paper.sd > 0.0; }
  bool spread_within(double factor) const { return ours.sd <= factor * paper.sd && ours.sd >= paper.sd / factor; }
  double ratio() const { return ours.mean / paper.mean; }
  // (ours − paper) over both standard errors and the rounding of the published figure
  double z_score() const;
  bool within_spread() const;  // of the paper's own runs: one standard deviation
  bool within(double share) const { return ratio() >= 1.0 - share && ratio() <= 1.0 + share; }
};

enum class Verdict { pass, fail, not_significant };
std::string_view to_string(Verdict verdict);

struct JudgedClaim {
  std::string claim;
  std::string table;
  Verdict verdict = Verdict::not_significant;
  double p_value = std::numeric_limits<double>::quiet_NaN();  // of our flights; NaN where there is nothing to test
  std::size_t n = 0;                                          // pairs, or flights
  double paper_p_value = std::numeric_limits<double>::quiet_NaN();  // of the published figures, Welch
  std::optional<Verdict> still{};                                   // the same in still air, where that was flown
  bool needs_gust() const { return verdict == Verdict::pass && still && *still != Verdict::pass; }
};

// One table of ours: the sweep of its experiment.
struct OurTable {
  std::string table;  // table1, …
  std::string experiment;
  std::string vehicle;
  std::vector<ResultRow> rows;
  bool all_replicates = false;     // every one counts, not as many as were published
  std::vector<ResultRow> still{};  // the same runs without any wind
  std::vector<NamedValue> arcs{};  // how much of each trajectory was flown
};

// Tables of as few runs as the paper's, drawn from one of ours with more of them: how many of their means are how near.
struct DrawnTables {
  std::string table;
  std::size_t gusts = 0, runs = 0;  // that were drawn from, in a drawn table
  struct Count {
    double expected, low, high;  // at most 10 % of the tables have less than low, at most 10 % more than high
  };
  Count within_25, within_50;  // per cent of the paper's
};

struct Reproduction {
  std::vector<ReproducedCell> cells;
  std::vector<DrawnTables> drawn;
  std::vector<JudgedClaim> claims;
};

// Tables, trajectories and controllers that were not flown leave out their cells and claims. Of a cell, as many replicates
// count as were published, unless its table says otherwise; of one where more count, tables are drawn, always the same gusts
// for the same number of them.
Reproduction reproduce(const Published& published, const std::vector<OurTable>& tables,
                       const std::function<Use(const PublishedRow&, std::size_t metric)>& use);

std::string to_json(const Reproduction& reproduction);
std::string to_markdown(const Reproduction& reproduction, const std::vector<OurTable>& tables);
// Ours over the paper's, logarithmic, a picture that stands alone.
std::string to_svg(const Reproduction& reproduction);

}  // namespace gustlab
