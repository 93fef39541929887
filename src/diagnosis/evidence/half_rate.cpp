#include "diagnosis/evidence/half_rate.hpp"

#include <utility>

#include "diagnosis/selection/select_effects.hpp"

namespace gustlab::diagnosis {

namespace {

bool same_numbers(const Catalogue& a, const Catalogue& b) {
  if (a.size() != b.size()) return false;
  for (int c = 0; c < a.size(); ++c)
    if (a.column(c).group != b.column(c).group || a.column(c).parameter != b.column(c).parameter ||
        a.column(c).flight != b.column(c).flight)
      return false;
  return true;
}

}  // namespace

FlightLog every_other_row(FlightLog log) {
  const auto thin = [](std::vector<double>& values) {
    for (std::size_t i = 0; 2 * i < values.size(); ++i) values[i] = values[2 * i];
    values.resize((values.size() + 1) / 2);
  };
  thin(log.time_s);
  for (LogColumn& column : log.columns) thin(column.values);
  return log;
}

std::vector<double> changes_at_half_rate(Session& half, const Session& session, const Selection& selection) {
  if (!same_numbers(half.catalogue(), session.catalogue())) return {};
  half.noise = selection.noise_selected;
  if (session.reference()) half.compare_with(*session.reference());
  const Eigen::VectorXd value = values_again(half, selection);
  std::vector<double> changes;
  for (const Finding& finding : selection.findings) {
    double along = 0.0, squared = 0.0;
    for (const int c : session.catalogue().group(finding.group).columns) {
      const Column& column = session.catalogue().column(c);
      const double size = (selection.value[c] - column.nominal) / column.natural;
      along += size * (value[c] - column.nominal) / column.natural;
      squared += size * size;
    }
    changes.push_back(squared > 0.0 ? along / squared - 1.0 : 0.0);
  }
  return changes;
}

}  // namespace gustlab::diagnosis
