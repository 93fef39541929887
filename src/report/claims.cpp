#include "report/claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "report/tables.hpp"

namespace gustlab {

namespace {

constexpr double level = 0.05;
constexpr double only_rounding = 1e9;  // differences that are so many of their standard errors are all alike
constexpr double far_outside = 3.0;    // a runaway's largest error, in those of the median run

std::string_view title(std::size_t metric) { return tracking_metrics[metric].title; }

Verdict verdict_of(const TTest& test) {
  if (!(test.p_value < level)) return Verdict::not_significant;
  return test.difference < 0.0 ? Verdict::pass : Verdict::fail;
}

// of the hypothesis that two paired samples scatter alike; difference < 0 when a scatters less
TTest scatter_test(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> sum, difference;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum.push_back(a[i] + b[i]);
    difference.push_back(a[i] - b[i]);
  }
  const Summary s = summarize(sum), d = summarize(difference);
  double covariance = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) covariance += (sum[i] - s.mean) * (difference[i] - d.mean);
  const double dof = static_cast<double>(a.size()) - 2.0;
  const double r = covariance / (static_cast<double>(a.size() - 1) * s.sd * d.sd);
  return t_test(r, std::sqrt((1.0 - r * r) / dof), dof);
}

class Judge {
 public:
  Judge(const Published& published, const std::vector<OurTable>& tables, const std::vector<ReproducedCell>& cells)
      : published_(published), tables_(tables), cells_(cells) {}

  const OurTable* find(const std::string& name) const {
    const auto table = std::find_if(tables_.begin(), tables_.end(), [&](const OurTable& t) { return t.table == name; });
    return table == tables_.end() ? nullptr : &*table;
  }

  void judge(const Claim& claim, std::vector<JudgedClaim>& out) const {
    if (find(claim.first.table) == nullptr || (!claim.second.table.empty() && find(claim.second.table) == nullptr))
      return;
    switch (claim.kind) {
      case ClaimKind::less:
      case ClaimKind::reduced:
      case ClaimKind::steadier:
        if (flown(claim.first) && flown(claim.second)) out.push_back(compared(claim));
        return;
      case ClaimKind::runaway:
        if (!trajectories(claim.first).empty()) out.push_back(runaway(claim));
        return;
      case ClaimKind::completion:
        if (!trajectories(claim.first).empty()) out.push_back(completion(claim));
        return;
      case ClaimKind::below:
        return below(claim, out);
    }
  }

 private:
  std::vector<double> values(const ClaimSide& side, std::size_t metric) const {
    return metric_of(counted_runs(published_, *find(side.table), side.trajectory, side.controller), metric);
  }

  bool flown(const ClaimSide& side) const {
    return !counted_runs(published_, *find(side.table), side.trajectory, side.controller).empty();
  }

  JudgedClaim compared(const Claim& claim) const {
    const std::vector<double> a = values(claim.first, claim.metric), b = values(claim.second, claim.metric);
    const bool paired = claim.first.trajectory == claim.second.trajectory;
    JudgedClaim judged{"", claim.first.table};
    judged.n = paired ? a.size() : a.size() + b.size();
    const std::string where = paired ? fmt::format("{} {}", claim.first.trajectory, title(claim.metric))
                                     : fmt::format("{} {}", claim.first.controller, title(claim.metric));
    judged.claim = fmt::format("{}: {} < {}", where, paired ? claim.first.controller : claim.first.trajectory,
                               paired ? claim.second.controller : claim.second.trajectory);

    const PublishedRow* paper_a = published_.find(claim.first.table, claim.first.trajectory, claim.first.controller);
    const PublishedRow* paper_b = published_.find(claim.second.table, claim.second.trajectory, claim.second.controller);
    if (paper_a != nullptr && paper_b != nullptr && claim.kind != ClaimKind::steadier)
      judged.paper_p_value = welch_test(paper_a->figures[claim.metric], paper_b->figures[claim.metric]).p_value;
    if (paired && a.size() != b.size()) return judged;

    const TTest test = claim.kind == ClaimKind::steadier ? scatter_test(a, b)
                       : paired                          ? paired_test(a, b)
                                                         : welch_test(summarize(a), summarize(b));
    // without scatter there is an order and nothing to test
    judged.p_value = std::abs(test.t) > only_rounding ? JudgedClaim{}.p_value : test.p_value;
    judged.verdict = verdict_of(test);
    if (claim.kind == ClaimKind::steadier)
      judged.claim =
          fmt::format("{}: {} scatters less than {}", where, claim.first.controller, claim.second.controller);
    if (claim.kind == ClaimKind::reduced) {
      const double ours = 1.0 - summarize(a).mean / summarize(b).mean;
      judged.claim = fmt::format("{}: {} {:.0f} % below {}, ours {:.0f} %", where, claim.first.controller,
                                 100.0 * claim.by, claim.second.controller, 100.0 * ours);
      // lower, and by the published share unless our flights rule that out
      std::vector<double> share;
      for (const double value : b) share.push_back((1.0 - claim.by) * value);
      const TTest less = paired_test(a, share);
      if (verdict_of(less) == Verdict::fail) judged.verdict = Verdict::fail;
    }
    return judged;
  }

  std::set<std::string> trajectories(const ClaimSide& side) const {
    std::set<std::string> names;
    for (const ResultRow& row : find(side.table)->rows)
      if (row.controller == side.controller) names.insert(row.trajectory);
    return names;
  }

  JudgedClaim runaway(const Claim& claim) const {
    JudgedClaim judged{fmt::format("{} has runaways", claim.first.controller), claim.first.table, Verdict::fail};
    for (const std::string& trajectory : trajectories(claim.first)) {
      const std::vector<double> most = values({claim.first.table, trajectory, claim.first.controller}, claim.metric);
      judged.n += most.size();
      const double typical = summarize(most).median;
      if (std::any_of(most.begin(), most.end(), [&](double value) { return value > far_outside * typical; }))
        judged.verdict = Verdict::pass;
    }
    return judged;
  }

  JudgedClaim completion(const Claim& claim) const {
    std::size_t completed = 0, all = 0;
    for (const std::string& trajectory : trajectories(claim.first))
      for (const ResultRow& row :
           counted_runs(published_, *find(claim.first.table), trajectory, claim.first.controller)) {
        ++all;
        completed += row.outcome == Outcome::completed;
      }
    return {fmt::format("{} {} (ours: {} of {} completed)", claim.first.controller,
                        claim.all ? "completes every run" : "crashes every time", completed, all),
            claim.first.table,
            completed == (claim.all ? all : 0) ? Verdict::pass : Verdict::fail,
            JudgedClaim{}.p_value,
            all,
            JudgedClaim{}.p_value};
  }

  // one claim per trajectory: all metrics and controllers that both tables have
  void below(const Claim& claim, std::vector<JudgedClaim>& out) const {
    for (const ReproducedCell& first : cells_) {
      if (first.table != claim.first.table) continue;
      const std::string says = fmt::format("{}: every {} error below that of {}", first.trajectory, first.vehicle,
                                           find(claim.second.table)->vehicle);
      auto judged = std::find_if(out.begin(), out.end(), [&](const JudgedClaim& c) { return c.claim == says; });
      const auto second = std::find_if(cells_.begin(), cells_.end(), [&](const ReproducedCell& c) {
        return c.table == claim.second.table && c.trajectory == first.trajectory && c.controller == first.controller &&
               c.metric == first.metric;
      });
      if (second == cells_.end() ||
          (first.trajectory == claim.except_trajectory && first.metric == claim.except_metric))
        continue;
      if (judged == out.end()) judged = out.insert(out.end(), {says, claim.first.table, Verdict::pass, -1.0, 0, 0.0});
      const TTest test = welch_test(first.ours, second->ours);
      // the weakest link speaks for all
      if (!(test.p_value <= judged->p_value)) {
        judged->p_value = test.p_value;
        judged->n = first.ours.n + second->ours.n;
      }
      judged->paper_p_value = std::max(judged->paper_p_value, welch_test(first.paper, second->paper).p_value);
      const Verdict verdict = verdict_of(test);
      if (verdict == Verdict::fail || judged->verdict == Verdict::pass) judged->verdict = verdict;
    }
  }

  const Published& published_;
  const std::vector<OurTable>& tables_;
  const std::vector<ReproducedCell>& cells_;
};

}  // namespace

std::vector<ResultRow> counted_runs(const Published& published, const OurTable& table, std::string_view trajectory,
                                    std::string_view controller) {
  // a controller without figures of its own flies as often as those that have some
  std::size_t most = 0;
  for (const PublishedRow& row : published.rows)
    if (row.table == table.table && row.trajectory == trajectory) most = std::max(most, row.figures[0].n);
  if (const PublishedRow* row = published.find(table.table, trajectory, controller)) most = row->figures[0].n;
  if (table.all_replicates) most = 0;
  std::vector<ResultRow> rows;
  for (const ResultRow& row : table.rows)
    if (row.trajectory == trajectory && row.controller == controller && (most == 0 || rows.size() < most))
      rows.push_back(row);
  return rows;
}

std::vector<double> metric_of(const std::vector<ResultRow>& rows, std::size_t metric) {
  std::vector<double> values;
  for (const ResultRow& row : rows) values.push_back(row.*tracking_metrics[metric].value);
  return values;
}

std::vector<JudgedClaim> judge_claims(const Published& published, const std::vector<OurTable>& tables,
                                      const std::vector<ReproducedCell>& cells) {
  const Judge judge(published, tables, cells);
  std::vector<JudgedClaim> judged;
  for (const Claim& claim : published.claims) judge.judge(claim, judged);
  return judged;
}

}  // namespace gustlab
