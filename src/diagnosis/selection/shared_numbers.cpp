#include "diagnosis/selection/shared_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/selection/trims.hpp"

namespace gustlab::diagnosis {

namespace {

// what a set leaves, and what its numbers cost (Schwarz, Ann. Stat. 6, 1978); infinite where a group in it would be a trim or has no possible value
double cost_of(const Session& session, const Eigen::MatrixXd& total, double rows, const std::vector<int>& groups,
               int must_be_possible) {
  const Catalogue& catalogue = session.catalogue();
  const std::vector<int> columns = session.with_biases(groups);
  const Fit fit = solve(total, columns);
  Eigen::VectorXd value = catalogue.nominal();
  for (std::size_t i = 0; i < columns.size(); ++i)
    value[columns[i]] += fit.coefficient[static_cast<Eigen::Index>(i)] * catalogue.column(columns[i]).natural;
  const auto admitted = [&](int c) { return catalogue.column(c).admits(value[c]); };
  if (must_be_possible >= 0 && (below_tolerance(session, value, must_be_possible) ||
                                !std::ranges::all_of(catalogue.group(must_be_possible).columns, admitted)))
    return std::numeric_limits<double>::infinity();
  return fit.loss + std::log(rows) * static_cast<double>(columns.size());
}

}  // namespace

std::vector<int> shared_instead(const Session& session, const Grams& grams, std::vector<int> chosen,
                                const std::set<int>& left_out) {
  const Catalogue& catalogue = session.catalogue();
  const SubsetSearch search(catalogue, session.vehicle(), 0.0);
  const Eigen::MatrixXd total = grams.total();
  for (const int force : std::vector<int>(chosen)) {
    if (!catalogue.group(force).row->per_flight) continue;
    const double now = cost_of(session, total, grams.rows, chosen, -1),
                 gain = solve(total, session.with_biases(search.without(chosen, force))).loss -
                        solve(total, session.with_biases(chosen)).loss;
    double least = now + decisions::nearly_all * gain;
    std::vector<int> best = chosen;
    for (const int other : search.candidates) {
      std::vector<int> instead = chosen;
      std::replace(instead.begin(), instead.end(), force, other);
      if (catalogue.group(other).row->per_flight || left_out.contains(other) || std::ranges::count(chosen, other) > 0 ||
          !search.allowed(instead))
        continue;
      if (const double cost = cost_of(session, total, grams.rows, instead, other); cost < least)
        least = cost, best = instead;
    }
    chosen = best;
    std::ranges::sort(chosen);
  }
  return chosen;
}

}  // namespace gustlab::diagnosis
