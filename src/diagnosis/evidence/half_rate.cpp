#include "diagnosis/evidence/half_rate.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "diagnosis/selection/select_effects.hpp"
#include "diagnosis/selection/suspect_histories.hpp"

namespace gustlab::diagnosis {

namespace {

// The column of `other` that is the same number of the same flight; −1: none.
int same_in(const Catalogue& other, const Catalogue& catalogue, int c) {
  const Column& column = catalogue.column(c);
  const int group = other.find(catalogue.group(column.group).label);
  if (group < 0) return -1;
  for (const int o : other.group(group).columns)
    if (other.column(o).parameter == column.parameter && other.column(o).flight == column.flight) return o;
  return -1;
}

bool same_effects(const Catalogue& a, const Catalogue& b) {
  return std::ranges::equal(a.groups(), b.groups(), [](const Group& x, const Group& y) {
    return x.label == y.label && x.candidate == y.candidate && x.columns.empty() == y.columns.empty();
  });
}

}  // namespace

FlightLog every_other_row(FlightLog log) {
  std::map<std::vector<bool>, std::size_t> seen;  // rows so far with values in these columns
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    std::vector<bool> has;
    for (const LogColumn& column : log.columns) has.push_back(std::isfinite(column.values[row]));
    if (seen[has]++ % 2 == 0) kept.push_back(row);
  }
  const auto thin = [&](std::vector<double>& values) {
    for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
    values.resize(kept.size());
  };
  thin(log.time_s);
  for (LogColumn& column : log.columns) thin(column.values);
  return log;
}

std::vector<double> changes_at_half_rate(Session& half, const Session& session, const Selection& selection) {
  const Catalogue &catalogue = session.catalogue(), &of_half = half.catalogue();
  if (!same_effects(catalogue, of_half)) return {};
  std::vector<int> groups;
  Eigen::VectorXd start = of_half.nominal();
  for (const Finding& finding : selection.findings) {
    const Group& group = catalogue.group(finding.group);
    groups.push_back(of_half.find(group.label));
    for (const std::vector<int> all = of_half.group(groups.back()).columns; const int c : all)
      if (same_in(catalogue, of_half, c) < 0) half.freeze(c);
    for (const int c : group.columns) {
      const int same = same_in(of_half, catalogue, c);
      if (same < 0) return {};
      start[same] = selection.value[c];
    }
  }
  half.noise = selection.noise_selected;
  suspect_histories_found(session, selection, half);
  if (session.reference()) half.compare_with(*session.reference());
  const Eigen::VectorXd value = values_with(half, groups, start);
  std::vector<double> changes;
  for (const Finding& finding : selection.findings) {
    double along = 0.0, squared = 0.0;
    for (const int c : catalogue.group(finding.group).columns) {
      const Column& column = catalogue.column(c);
      const double size = (selection.value[c] - column.nominal) / column.natural;
      along += size * (value[same_in(of_half, catalogue, c)] - column.nominal) / column.natural;
      squared += size * size;
    }
    changes.push_back(squared > 0.0 ? along / squared - 1.0 : 0.0);
  }
  return changes;
}

}  // namespace gustlab::diagnosis
