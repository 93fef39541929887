#include "diagnosis/validation/parts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "diagnosis/estimation/indices.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/trims.hpp"
#include "diagnosis/validation/generic_bases.hpp"
#include "diagnosis/validation/remainder.hpp"

namespace gustlab::diagnosis {

namespace {

// A flight with further columns, named −1, −2, …: the force of each finding, as it was found; then, where forces to the side are
// free, those to the side.
LinearFlight with_forces(const LinearFlight& flight, const Session& session, const Selection& selection,
                         const std::vector<int>& beside, bool sideways_free) {
  const Catalogue& catalogue = session.catalogue();
  const auto tested = static_cast<Eigen::Index>(selection.findings.size()),
             forces = sideways_free ? 2 * tested : tested;
  LinearFlight out = only(flight, beside);
  const auto own = static_cast<Eigen::Index>(out.columns.size());
  for (Eigen::Index i = 0; i < forces; ++i) out.columns.push_back(static_cast<int>(-1 - i));
  for (std::size_t k = 0; k < flight.size(); ++k) {
    auto& acceleration = out.acceleration_by[k];
    auto& felt = out.felt_by[k];
    acceleration.conservativeResize(Eigen::NoChange, own + forces),
        felt.conservativeResize(Eigen::NoChange, own + forces);
    acceleration.rightCols(forces).setZero(), felt.rightCols(forces).setZero();
    for (std::size_t j = 0; j < flight.columns.size(); ++j) {
      const Column& column = catalogue.column(flight.columns[j]);
      const auto at = static_cast<Eigen::Index>(j);
      for (Eigen::Index i = 0; i < tested; ++i) {
        if (column.group != selection.findings[static_cast<std::size_t>(i)].group) continue;
        const double size = (selection.value[flight.columns[j]] - column.nominal) / column.natural;
        // what moves nothing is a sensor's error and no force; that of a body is seen from where the pose has its origin, which no file knows
        const auto push = flight.acceleration_by[k].col(at).head<3>();
        if (catalogue.group(column.group).row->place == Place::body || push.isZero(0.0)) continue;
        acceleration.col(own + i).head<3>() += size * push;
        felt.col(own + i) += size * flight.felt_by[k].col(at);
      }
    }
    for (Eigen::Index i = 0; sideways_free && i < tested; ++i) {
      acceleration.col(own + i).head<2>().swap(acceleration.col(own + tested + i).head<2>());
      const Vector3 up = flight.R_WB[k].row(2).transpose(), all = felt.col(own + i);
      felt.col(own + i) = up * up.dot(all), felt.col(own + tested + i) = all - up * up.dot(all);
    }
  }
  return out;
}

// of these columns, that every flight has `with` what it is asked
Grams grams_of(const Session& session, const std::vector<int>& columns,
               const std::function<LinearFlight(const LinearFlight&)>& with) {
  std::vector<Grams> of_flight(session.flights().size());
  session.for_each_flight([&](std::size_t f) {
    const LinearFlight linear = with(session.linear()[f]);
    GramBlocks blocks(indices_of(linear.columns, columns), static_cast<int>(f), static_cast<int>(columns.size()),
                      of_flight[f]);
    add_innovations(session.flights()[f], linear, session.noise, blocks);
  });
  Grams grams;
  for (Grams& part : of_flight) append(std::move(part), grams);
  return grams;
}

// How much of what a finding does its force does: what the finding's own columns, of those `beside`, take of it. `pattern`: of the force, less
// what others say of it.
double force_share(const Catalogue& catalogue, const Selection& selection, int group, const std::vector<int>& beside,
                   const Eigen::MatrixXd& gram, const Eigen::VectorXd& pattern) {
  Eigen::VectorXd size = Eigen::VectorXd::Zero(gram.cols()), of_force = size;
  for (std::size_t k = 0; k < beside.size(); ++k) {
    const Column& column = catalogue.column(beside[k]);
    if (column.group != group) continue;
    const auto at = static_cast<Eigen::Index>(k);
    size[at] = (selection.value[beside[k]] - column.nominal) / column.natural;
    of_force[at] = -pattern[at];
  }
  const Eigen::VectorXd seen = gram * size;
  return std::clamp(of_force.dot(seen) / size.dot(seen), 0.0, 1.0);
}

}  // namespace

std::vector<Parts> parts(const Session& session, const Selection& selection) {
  std::vector<Parts> result(selection.findings.size());
  const auto turns = [](const LinearFlight& flight) { return flight.torque_known && !flight.forces_alone; };
  if (session.shoots() || selection.findings.empty() ||
      !std::all_of(session.linear().begin(), session.linear().end(), turns))
    return result;
  // a gust moves the vehicle along its own force, and lasts longer than what the filter allows for: then forces to the side are free
  const bool gusty = session.noise.rms(0) > decisions::most_of_floor * reference_floor(session.vehicle())[0];
  const auto tested = static_cast<Eigen::Index>(result.size()), forces = gusty ? 2 * tested : tested;
  std::vector<int> beside = session.with_biases(selection.groups());
  const std::vector<Trim> trims = trims_beside(session, beside, decisions::scatter_share);
  const std::size_t own = beside.size();
  for (const Trim& trim : trims) beside.push_back(trim.column);
  std::vector<int> all = beside;
  for (int i = 0; i < forces; ++i) all.push_back(-1 - i);
  const Grams grams = grams_of(
      session, all, [&](const LinearFlight& flight) { return with_forces(flight, session, selection, beside, gusty); });
  Eigen::MatrixXd gram = grams.total();
  keep_small(trims, own, gram);
  std::vector<int> known(beside.size());
  std::iota(known.begin(), known.end(), 0);
  for (Eigen::Index i = tested; i < forces; ++i)
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
    if (!(seen >
          std::max(decisions::least_force_seen, decisions::least_force_share * selection.findings[i].delta_chi2)))
      continue;
    const Eigen::VectorXd pattern = left_of(at);
    const double excess = projected(at, projected.cols() - 1) / seen;
    const double share =
        force_share(session.catalogue(), selection, selection.findings[i].group, beside, gram, pattern);
    result[i] = {excess,
                 std::sqrt(std::max(1.0 / seen, clustered_variance(grams, pattern, unexplained - excess * pattern))),
                 excess > 0.0 ? excess * share : -excess * (1.0 - share)};
  }
  return result;
}

}  // namespace gustlab::diagnosis
