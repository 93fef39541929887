// Best subsets of groups on one Gram matrix from which all that is always free has been projected out.
#pragma once

#include <set>
#include <vector>

#include "diagnosis/estimation/gram.hpp"
#include "diagnosis/model/catalogue.hpp"

namespace gustlab::diagnosis {

struct Subset {
  std::vector<int> groups;  // sorted
  double loss = 0.0;
  double score = 0.0;  // loss + parameters × log(dof)
};

struct SubsetSearch {
  SubsetSearch(const Catalogue& catalogue, const VehicleModel& vehicle, double penalty);

  // The best subsets of each size, best first.
  std::vector<std::vector<Subset>> run(const Eigen::MatrixXd& gram, int most, int beam) const;
  // The subset to choose when every further group must gain at least `material`.
  static Subset choose(const std::vector<std::vector<Subset>>& by_size, double material);
  // Loss of one subset; infinite when a coefficient leaves its bounds or a group needs another that is missing.
  Subset evaluate(const Eigen::MatrixXd& gram, const std::vector<int>& groups) const;
  // One group more, or (`exchange`) one for another or for two, where that pays most: at least what a further effect must gain, of which one effect
  // less is worth as much. Empty: nothing does.
  std::vector<int> improved(const Eigen::MatrixXd& gram, const std::vector<int>& groups,
                            const std::set<std::vector<int>>& visited, double material, bool exchange) const;
  // What the best of all candidates gains by chance beyond the price of its numbers (Chen and Chen, Biometrika 95, 2008, γ = 1), Δχ².
  double gained_by_chance() const;
  bool allowed(const std::vector<int>& groups) const;
  // `groups` without one of them, and without a wind that nothing feels any more.
  std::vector<int> without(std::vector<int> groups, int group) const;
  // Where the coefficients of what would leave with a group stand among those of `groups`.
  std::vector<Eigen::Index> leaving(const std::vector<int>& groups, int group) const;
  // Loss of `columns`, whose fit is `fit`, with those values of a group that leave their bounds held there and all others fitted.
  double loss_within_bounds(const Eigen::MatrixXd& gram, const std::vector<int>& columns, const Fit& fit,
                            int group) const;

  const Catalogue& catalogue;
  double penalty;
  std::vector<int> candidates;
};

}  // namespace gustlab::diagnosis
