#include "diagnosis/selection/subset_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/selection.hpp"

namespace gustlab::diagnosis {

namespace {

double fitted_value(const Column& column, const Fit& fit, std::size_t i) {
  return column.nominal + fit.coefficient[static_cast<Eigen::Index>(i)] * column.natural;
}

}  // namespace

SubsetSearch::SubsetSearch(const Catalogue& known, const VehicleModel&, double per_parameter)
    : catalogue(known), penalty(per_parameter) {
  for (std::size_t g = 0; g < catalogue.groups().size(); ++g)
    if (const Group& group = catalogue.groups()[g]; group.candidate && !group.columns.empty())
      candidates.push_back(static_cast<int>(g));
}

double SubsetSearch::gained_by_chance() const {
  return 2.0 * std::log(static_cast<double>(std::max<std::size_t>(1, candidates.size())));
}

bool SubsetSearch::allowed(const std::vector<int>& groups) const {
  // without an effect that feels the air a wind is not felt
  bool wind = false, felt = false;
  // two means, of roll and pitch, show one thing that shifts them
  int shifts = 0;
  std::vector<std::string_view> names, apart;
  for (std::size_t g = 0; g < catalogue.groups().size(); ++g) {
    const Group& group = catalogue.groups()[g];
    const EffectRow& row = *group.row;
    const bool in = std::find(groups.begin(), groups.end(), static_cast<int>(g)) != groups.end();
    if (in) names.push_back(row.name), apart.push_back(row.never_beside);
    if (in && row.air == Airflow::wind) wind = true;
    if (in && shifts_torques(row)) ++shifts;
    if ((in || group.nominal) && (row.air == Airflow::felt || row.air == Airflow::drag)) felt = true;
  }
  return (!wind || felt) && (shifts <= 1 || !catalogue.mean_torques_alone()) &&
         std::find_first_of(names.begin(), names.end(), apart.begin(), apart.end()) == names.end();
}

std::vector<int> SubsetSearch::without(std::vector<int> groups, int group) const {
  std::erase(groups, group);
  if (!allowed(groups)) std::erase(groups, catalogue.find(Airflow::wind));
  return groups;
}

std::vector<Eigen::Index> SubsetSearch::leaving(const std::vector<int>& groups, int group) const {
  const std::vector<int> rest = without(groups, group);
  std::vector<Eigen::Index> at;
  Eigen::Index next = 0;
  for (const int g : groups) {
    const bool leaves = std::ranges::find(rest, g) == rest.end();
    for (std::size_t i = own_columns(catalogue, groups, g).size(); i > 0; --i, ++next)
      if (leaves) at.push_back(next);
  }
  return at;
}

double SubsetSearch::loss_within_bounds(const Eigen::MatrixXd& gram, const std::vector<int>& columns, const Fit& fit,
                                        int group) const {
  std::vector<int> free;
  Eigen::VectorXd held = Eigen::VectorXd::Zero(catalogue.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = catalogue.column(columns[i]);
    const double value = fitted_value(column, fit, i);
    if (column.group != group || column.admits(value)) free.push_back(columns[i]);
    else held[columns[i]] = (std::clamp(value, column.min, column.max) - column.nominal) / column.natural;
  }
  return solve(shifted(gram, -held), free).loss;
}

Subset SubsetSearch::evaluate(const Eigen::MatrixXd& gram, const std::vector<int>& groups) const {
  Subset subset;
  subset.groups = groups;
  const std::vector<int> columns = columns_of(catalogue, groups);
  const Fit fit = solve(gram, columns);
  subset.loss = fit.loss;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = catalogue.column(columns[i]);
    if (!column.admits(fitted_value(column, fit, i))) subset.loss = std::numeric_limits<double>::infinity();
  }
  subset.score = subset.loss + penalty * static_cast<double>(columns.size());
  // a cable's length and its swing in every flight were fitted beforehand
  for (const int g : groups)
    if (const ColumnFrom column = catalogue.group(g).row->column; column == ColumnFrom::swing)
      subset.score += decisions::swing_costs * penalty;
    else if (column == ColumnFrom::speed_limit) subset.score += decisions::limit_costs * penalty;
  return subset;
}

std::vector<std::vector<Subset>> SubsetSearch::run(const Eigen::MatrixXd& gram, int most, int beam) const {
  std::vector<std::vector<Subset>> by_size{{evaluate(gram, {})}};
  std::vector<std::vector<int>> bases{{}};
  for (int size = 1; size <= most; ++size) {
    std::set<std::vector<int>> tried;
    std::vector<Subset> found;
    for (const auto& base : bases)
      for (const int g : candidates) {
        if (std::find(base.begin(), base.end(), g) != base.end()) continue;
        std::vector<int> groups = base;
        groups.insert(std::upper_bound(groups.begin(), groups.end(), g), g);
        if (tried.insert(groups).second) found.push_back(evaluate(gram, groups));
      }
    // ties in the order of the catalogue, so that the same data give the same answer
    std::stable_sort(found.begin(), found.end(), [](const Subset& a, const Subset& b) { return a.score < b.score; });
    // every single is a base of the next round, even one that needs a companion
    bases.clear();
    const std::size_t kept =
        size == 1 ? found.size() : std::min<std::size_t>(found.size(), static_cast<std::size_t>(beam));
    for (std::size_t i = 0; i < kept; ++i) bases.push_back(found[i].groups);
    std::erase_if(found, [this](const Subset& s) { return !allowed(s.groups); });
    if (found.size() > static_cast<std::size_t>(beam)) found.resize(static_cast<std::size_t>(beam));
    by_size.push_back(std::move(found));
    if (bases.empty()) break;
  }
  return by_size;
}

std::vector<int> SubsetSearch::improved(const Eigen::MatrixXd& gram, const std::vector<int>& groups,
                                        const std::set<std::vector<int>>& visited, double material,
                                        bool exchange) const {
  double best = evaluate(gram, groups).score - material;
  std::vector<int> better;
  const auto try_groups = [&](std::vector<int> changed) {
    std::sort(changed.begin(), changed.end());
    if (visited.contains(changed) || !allowed(changed)) return;
    const double saved = changed.size() < groups.size() ? material : 0.0;
    const double score = evaluate(gram, changed).score - saved;
    if (score < best) best = score, better = std::move(changed);
  };
  for (const int g : candidates) {
    if (std::find(groups.begin(), groups.end(), g) != groups.end()) continue;
    std::vector<int> more = groups;
    more.push_back(g);
    try_groups(more);
    // an exchange costs no further effect, but should pay as much
    for (std::size_t i = 0; exchange && i < groups.size(); ++i) {
      std::vector<int> changed = groups;
      changed[i] = g;
      try_groups(changed);
      // two effects for one that does what they do
      for (std::size_t j = 0; j < i; ++j) {
        std::vector<int> fewer = changed;
        fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(j));
        try_groups(std::move(fewer));
      }
    }
  }
  return better;
}

Subset SubsetSearch::choose(const std::vector<std::vector<Subset>>& by_size, double material) {
  Subset best = by_size[0].front();
  for (std::size_t size = 1; size < by_size.size(); ++size) {
    if (by_size[size].empty()) continue;
    const Subset& candidate = by_size[size].front();
    const double more = static_cast<double>(size) - static_cast<double>(best.groups.size());
    if (candidate.score < best.score - material * more) best = candidate;
  }
  return best;
}

}  // namespace gustlab::diagnosis
