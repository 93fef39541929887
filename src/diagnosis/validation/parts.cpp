#include "diagnosis/validation/parts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/trims.hpp"
#include "diagnosis/validation/generic_bases.hpp"
#include "diagnosis/validation/remainder.hpp"

namespace gustlab::diagnosis {

namespace {

// SpatialAccelerations of each finding, as accelerations per unit of what was found; then, where pushes to the side are free, those to the side.
BasisFamily pushes_of(const Session& session, const Selection& selection, bool sideways_free) {
  const Catalogue& catalogue = session.catalogue();
  const auto tested = static_cast<Eigen::Index>(selection.findings.size());
  BasisFamily pushes;
  pushes.size = static_cast<int>(sideways_free ? 2 * tested : tested);
  for (const LinearFlight& flight : session.linear()) {
    std::vector<SpatialAccelerations>& of_flight =
        pushes.columns.emplace_back(flight.size(), SpatialAccelerations::Zero(6, pushes.size));
    for (std::size_t k = 0; k < flight.size(); ++k)
      for (Eigen::Index i = 0; i < tested; ++i) {
        Eigen::Matrix<double, 12, 1> moved = Eigen::Matrix<double, 12, 1>::Zero();
        for (std::size_t j = 0; j < flight.columns.size(); ++j) {
          const Column& column = catalogue.columns()[static_cast<std::size_t>(flight.columns[j])];
          if (column.group != selection.findings[static_cast<std::size_t>(i)].group) continue;
          moved += (selection.value[flight.columns[j]] - column.nominal) / column.natural / flight.interval_s[k] *
                   flight.B[k].col(static_cast<Eigen::Index>(j));
        }
        of_flight[k].block<3, 1>(0, i) = moved.segment<3>(3);
        if (sideways_free) of_flight[k].block<2, 1>(0, i).swap(of_flight[k].block<2, 1>(0, tested + i));
      }
  }
  return pushes;
}

}  // namespace

std::vector<Parts> parts(const Session& session, const Selection& selection) {
  std::vector<Parts> result(selection.findings.size());
  const auto turns = [](const LinearFlight& flight) { return flight.torque_known && !flight.forces_alone; };
  if (session.shoots() || selection.findings.empty() ||
      !std::all_of(session.linear().begin(), session.linear().end(), turns))
    return result;
  // a gust moves the vehicle along its own push, and lasts longer than what the filter allows for: then pushes to the side are free
  const bool gusty = session.noise.rms(0) > decisions::most_of_floor * reference_floor(session.vehicle())[0];
  const BasisFamily pushes = pushes_of(session, selection, gusty);
  const auto tested = static_cast<Eigen::Index>(result.size());
  std::vector<int> beside = session.with_biases(selection.groups());
  const std::vector<Trim> trims = trims_beside(session, beside, decisions::scatter_share);
  const std::size_t own = beside.size();
  for (const Trim& trim : trims) beside.push_back(trim.column);
  const Grams grams = grams_with(session, pushes, beside);
  Eigen::MatrixXd gram = grams.total();
  keep_small(trims, own, gram);
  std::vector<int> known(beside.size());
  std::iota(known.begin(), known.end(), 0);
  for (Eigen::Index i = tested; i < pushes.size; ++i)
    known.push_back(static_cast<int>(static_cast<Eigen::Index>(beside.size()) + i));
  const Eigen::MatrixXd projected = project_out(gram, known);
  // what is left of a column, the known ones fitted to it
  const auto left_of = [&](Eigen::Index column) {
    Eigen::MatrixXd target = gram;
    target.col(target.cols() - 1) = gram.col(column);
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(gram.cols());
    const Eigen::VectorXd others = solve(target, known).coefficient;
    for (std::size_t i = 0; i < known.size(); ++i) weights[known[i]] = -others[static_cast<Eigen::Index>(i)];
    weights[column] = 1.0;
    return weights;
  };
  const Eigen::VectorXd unexplained = left_of(gram.cols() - 1);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(beside.size() + i);
    const double seen = projected(at, at);
    if (!(seen > decisions::least_push_seen)) continue;
    const Eigen::VectorXd pattern = left_of(at);
    const double excess = projected(at, projected.cols() - 1) / seen;
    result[i] = {excess,
                 std::sqrt(std::max(1.0 / seen, clustered_variance(grams, pattern, unexplained - excess * pattern)))};
  }
  return result;
}

}  // namespace gustlab::diagnosis
