#include "diagnosis/parts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/generic_bases.hpp"
#include "diagnosis/trims.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double least_seen = 25.0;   // χ² of a push that is not there, with everything else free

}  // namespace

std::vector<Parts> parts(const Session& session, const Selection& selection) {
  std::vector<Parts> result(selection.findings.size());
  if (session.shoots() || selection.findings.empty()) return result;
  const Catalogue& catalogue = session.catalogue();
  BasisFamily pushes;
  pushes.size = static_cast<int>(selection.findings.size());
  for (const LinearFlight& flight : session.linear()) {
    std::vector<Pushes>& of_flight = pushes.columns.emplace_back(flight.size(), Pushes::Zero(6, pushes.size));
    for (std::size_t i = 0; i < selection.findings.size(); ++i)
      for (std::size_t j = 0; j < flight.columns.size(); ++j) {
        const Column& column = catalogue.columns()[static_cast<std::size_t>(flight.columns[j])];
        if (column.group != selection.findings[i].group) continue;
        const double size = (selection.value[flight.columns[j]] - column.nominal) / column.natural;
        for (std::size_t k = 0; k < flight.size(); ++k)
          of_flight[k].block<3, 1>(0, static_cast<Eigen::Index>(i)) += size / flight.interval_s[k] * flight.B[k].block<3, 1>(3, static_cast<Eigen::Index>(j));
      }
  }
  std::vector<int> beside = session.with_biases(selection.groups());
  const std::vector<Trim> trims = trims_beside(session, beside, scatter_share);
  const std::size_t own = beside.size();
  for (const Trim& trim : trims) beside.push_back(trim.column);
  Eigen::MatrixXd gram = gram_with(session, pushes, beside);
  for (std::size_t i = 0; i < trims.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(own + i);
    gram(at, at) += 1.0 / (trims[i].deviation * trims[i].deviation);
  }
  std::vector<int> known;
  for (std::size_t i = 0; i < beside.size(); ++i) known.push_back(static_cast<int>(i));
  const Eigen::MatrixXd left = project_out(gram, known);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(beside.size() + i);
    const double seen = left(at, at);
    if (seen > least_seen) result[i] = {left(at, left.cols() - 1) / seen, 1.0 / std::sqrt(seen)};
  }
  return result;
}

}  // namespace gustlab::diagnosis
