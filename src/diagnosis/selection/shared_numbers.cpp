#include "diagnosis/selection/shared_numbers.hpp"

#include <algorithm>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/subset_search.hpp"
#include "diagnosis/selection/trims.hpp"

namespace gustlab::diagnosis {

namespace {

// whether a fitted set gives a group a value that is possible and no trim
bool may_be_named(const Session& session, const Eigen::VectorXd& value, int group) {
  return !below_tolerance(session, value, group) && possible(session.catalogue(), value, group);
}

// whether a group looks like a force of the flights unless these turn, and is far less usual in its size than that force (natural sizes)
bool is_the_less_usual(const Catalogue& catalogue, const Eigen::VectorXd& value, int group, int force, double size) {
  return std::ranges::count(catalogue.group(group).row->like_unless_turning, catalogue.group(force).row->name) > 0 &&
         is_far_more_usual(size, size_in_naturals(catalogue, value, group));
}

}  // namespace

std::vector<int> shared_instead(const Session& session, const Grams& grams, std::vector<int> chosen,
                                const std::set<int>& left_out) {
  const Catalogue& catalogue = session.catalogue();
  const SubsetSearch search(catalogue, session.vehicle(), 0.0);
  const Eigen::MatrixXd total = grams.total();
  for (const int force : std::vector<int>(chosen)) {
    if (!catalogue.group(force).row->per_flight) continue;
    const std::vector<int> columns = session.with_biases(chosen);
    const Fit own = solve(total, columns);
    const double size = size_in_naturals(catalogue, value_at(catalogue, columns, own), force), loss = own.loss,
                 gain = solve(total, session.with_biases(search.without(chosen, force))).loss - loss;
    double least = loss + grams.price(columns.size()) + decisions::nearly_all * gain;
    std::vector<int> best = chosen;
    for (const int other : search.candidates) {
      std::vector<int> instead = chosen;
      std::replace(instead.begin(), instead.end(), force, other);
      if (catalogue.group(other).row->per_flight || left_out.contains(other) || std::ranges::count(chosen, other) > 0 ||
          !search.allowed(instead))
        continue;
      const std::vector<int> other_columns = session.with_biases(instead);
      const Fit fit = solve(total, other_columns);
      const double cost = fit.loss + grams.price(other_columns.size());
      const Eigen::VectorXd value = value_at(catalogue, other_columns, fit);
      if (cost < least && may_be_named(session, value, other) &&
          !is_the_less_usual(catalogue, value, other, force, size))
        least = cost, best = instead;
    }
    chosen = best;
    std::ranges::sort(chosen);
  }
  return chosen;
}

}  // namespace gustlab::diagnosis
