#include "diagnosis/selection/trims.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

double size_in_tolerances(const Session& session, const Eigen::VectorXd& value, int group) {
  const auto& flights = session.flights();
  const bool hold_known = std::all_of(flights.begin(), flights.end(), [](const FlightData& f) { return f.hold_known; });
  double largest = 0.0;
  const Group& of = session.catalogue().group(group);
  for (const int c : of.columns) {
    const Column& column = session.catalogue().column(c);
    double tolerance = column.tolerance;
    // a lag or delay of part of a sample is a convention of the log, unless it tells how commands are held
    if (column.unit == "s" && tolerance > 0.0 && !hold_known)
      tolerance = std::max(tolerance, decisions::unknown_hold_samples * session.logged_sample_s());
    if (session.noise.errors_last()) tolerance = std::max(tolerance, column.estimate_tolerance);
    // the same vehicle in another flight has not quite the same numbers
    if (session.reference()) {
      tolerance = std::max(tolerance, decisions::same_again_share * std::abs(column.nominal));
      const auto& known = session.reference()->of_each_flight;
      if (const auto own = known.find({of.label, column.parameter}); own != known.end())
        tolerance = std::max(tolerance, decisions::same_again_scatter * own->second);
    }
    if (tolerance == 0.0) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, std::abs(value[c] - column.nominal) / tolerance);
  }
  return largest;
}

bool below_tolerance(const Session& session, const Eigen::VectorXd& value, int group) {
  return size_in_tolerances(session, value, group) < decisions::scatter_margin;
}

std::vector<Trim> trims_beside(const Session& session, const std::vector<int>& columns, double share) {
  std::vector<Trim> trims;
  for (int c = 0; c < session.catalogue().size(); ++c) {
    const Column& column = session.catalogue().column(c);
    if (column.tolerance > 0.0 && std::find(columns.begin(), columns.end(), c) == columns.end())
      trims.push_back({c, share * column.tolerance / column.natural});
  }
  return trims;
}

bool imitated_by_scatter(const Session& session, const Eigen::MatrixXd& total, const std::vector<int>& chosen,
                         int group) {
  const Catalogue& catalogue = session.catalogue();
  const std::vector<int>& own = catalogue.group(group).columns;
  if (catalogue.column(own.front()).tolerance == 0.0) return false;
  std::vector<int> firm;
  for (const int g : chosen)
    if (g != group) {
      const auto& columns = catalogue.group(g).columns;
      firm.insert(firm.end(), columns.begin(), columns.end());
    }
  Eigen::MatrixXd soft = total;
  std::vector<int> without = firm;
  without.insert(without.end(), session.biases().begin(), session.biases().end());
  for (const Trim& trim : trims_beside(session, firm, decisions::trim_share)) {
    soft(trim.column, trim.column) += 1.0 / (trim.deviation * trim.deviation);
    without.push_back(trim.column);
  }
  Eigen::MatrixXd free = soft;
  for (const int c : own) {
    if (catalogue.column(c).tolerance == 0.0) without.push_back(c);
    else free(c, c) = total(c, c);
  }
  return solve(soft, without).loss - solve(free, without).loss < decisions::trim_cost;
}

}  // namespace gustlab::diagnosis
