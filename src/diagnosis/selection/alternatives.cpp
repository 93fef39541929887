#include "diagnosis/selection/alternatives.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/subset_search.hpp"

namespace gustlab::diagnosis {

namespace {

// every one, two and three of some groups
std::vector<std::vector<int>> few_of(const std::vector<int>& groups) {
  std::vector<std::vector<int>> subsets;
  const std::size_t n = groups.size();
  for (std::size_t i = 0; i < n; ++i) {
    subsets.push_back({groups[i]});
    for (std::size_t j = i + 1; j < n; ++j) {
      subsets.push_back({groups[i], groups[j]});
      for (std::size_t k = j + 1; k < n; ++k) subsets.push_back({groups[i], groups[j], groups[k]});
    }
  }
  return subsets;
}

}  // namespace

std::vector<std::vector<int>> alternatives(const Session& session, const Selection& standing,
                                           const std::set<int>& left_out) {
  const SubsetSearch search(session.catalogue(), session.vehicle(), std::log(standing.grams.rows));
  const Eigen::MatrixXd gram = project_out(standing.grams.total(), session.biases());
  const auto loss_of = [&](const std::vector<int>& groups) {
    return solve(gram, columns_of(session.catalogue(), groups)).loss;
  };
  const std::vector<int> all = standing.groups();
  const double loss = loss_of(all);
  std::vector<int> named;
  for (const Finding& finding : standing.findings)
    if (!finding.calibration) named.push_back(finding.group);

  std::vector<int> others = search.candidates;
  std::erase_if(others, [&](int g) {
    return session.catalogue().group(g).row->per_flight || left_out.contains(g) || standing.at_bounds.contains(g) ||
           std::ranges::count(all, g) > 0;
  });
  std::vector<Subset> best(others.size());
  for (Subset& subset : best) subset.score = std::numeric_limits<double>::infinity();
  for (const std::vector<int>& some : few_of(named)) {
    std::vector<int> rest = all;
    for (const int g : some) rest = search.without(rest, g);
    const double may_lose = decisions::most_lost_to_rival * (loss_of(rest) - loss);
    for (std::size_t i = 0; i < others.size(); ++i) {
      if (some.size() == 1 && std::ranges::any_of(standing.find(some[0])->rivals, [&](const Rival& rival) {
            return rival.group == others[i] && equal(rival, *standing.find(some[0]));
          }))
        continue;
      std::vector<int> groups = rest;
      groups.insert(std::ranges::upper_bound(groups, others[i]), others[i]);
      if (!search.allowed(groups)) continue;
      Subset subset = search.evaluate(gram, groups);
      if (subset.loss - loss < may_lose && subset.score < best[i].score) best[i] = std::move(subset);
    }
  }
  std::ranges::stable_sort(best, {}, &Subset::score);
  std::vector<std::vector<int>> sets;
  for (Subset& subset : best)
    if (!std::isinf(subset.score) && sets.size() < decisions::most_alternatives)
      sets.push_back(std::move(subset.groups));
  return sets;
}

}  // namespace gustlab::diagnosis
