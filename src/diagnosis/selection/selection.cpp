#include "diagnosis/selection/selection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gustlab::diagnosis {

std::vector<int> joined(std::vector<int> groups, const std::vector<int>& further) {
  groups.insert(groups.end(), further.begin(), further.end());
  std::ranges::sort(groups);
  groups.erase(std::ranges::unique(groups).begin(), groups.end());
  return groups;
}

std::vector<int> Selection::groups() const {
  std::vector<int> result;
  for (const Finding& finding : findings) result.push_back(finding.group);
  return result;
}

const Finding* Selection::find(int group) const {
  for (const Finding& finding : findings)
    if (finding.group == group) return &finding;
  return nullptr;
}

Settled settled(const Session& session, Selection selection) {
  return {std::move(selection), session.learned(), session.value(), session.frozen()};
}

Selection go_back(Session& session, Settled before) {
  session.put_back(std::move(before.learned));
  session.freeze_only(before.frozen);
  session.linearise(before.linearised_at, session.all_columns());
  return std::move(before.selection);
}

Eigen::VectorXd value_at(const Catalogue& catalogue, const std::vector<int>& columns, const Fit& fit) {
  Eigen::VectorXd value = catalogue.nominal();
  for (std::size_t i = 0; i < columns.size(); ++i)
    value[columns[i]] += fit.coefficient[static_cast<Eigen::Index>(i)] * catalogue.column(columns[i]).natural;
  return value;
}

bool possible(const Catalogue& catalogue, const Eigen::VectorXd& value, int group) {
  return std::ranges::all_of(catalogue.group(group).columns,
                             [&](int c) { return catalogue.column(c).admits(value[c]); });
}

double size_in_naturals(const Catalogue& catalogue, const Eigen::VectorXd& value, int group) {
  double largest = 0.0;
  for (const int c : catalogue.group(group).columns) {
    const Column& column = catalogue.column(c);
    largest = std::max(largest, std::abs(value[c] - column.nominal) / column.natural);
  }
  return largest;
}

bool is_far_more_usual(double size, double than) {
  return than >= decisions::unusual_from && size < decisions::far_more_usual * than;
}

bool at_its_bound(const Catalogue& catalogue, const Eigen::VectorXd& value, int group) {
  return std::ranges::any_of(catalogue.group(group).columns, [&](int c) {
    const Column& column = catalogue.column(c);
    return value[c] != column.nominal && value[c] != 0.0 && (value[c] <= column.min || value[c] >= column.max);
  });
}

bool is_told(const Rival& rival) {
  return rival.z >= decisions::equivalent_z && rival.delta_chi2 >= decisions::least_told_chi2;
}

bool equal(const Rival& rival, const Finding& finding) {
  const double share = is_told(rival) ? decisions::least_told_share : decisions::most_lost_to_rival;
  return rival.delta_chi2 < share * finding.delta_chi2;
}

}  // namespace gustlab::diagnosis
