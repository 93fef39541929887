#include "diagnosis/estimation/reference.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

// numbers that a vehicle has: not those of one flight, and no history that a scan of these flights found
bool is_shared(const Catalogue& catalogue, const Column& column) {
  return column.group >= 0 && column.flight < 0 &&
         !catalogue.groups()[static_cast<std::size_t>(column.group)].row->is_history();
}

std::pair<std::string, int> name_of(const Catalogue& catalogue, const Column& column) {
  return {catalogue.groups()[static_cast<std::size_t>(column.group)].label, column.parameter};
}

}  // namespace

Reference reference_of(const Catalogue& catalogue, const Grams& grams, const std::vector<int>& biases) {
  std::vector<int> free = biases, shared;
  Reference reference;
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    if (column.group >= 0 && column.flight >= 0) free.push_back(c);
    if (!is_shared(catalogue, column)) continue;
    shared.push_back(c);
    reference.column.push_back(name_of(catalogue, column));
  }
  reference.information = project_out(grams.total(), free)(shared, shared);
  return reference;
}

Grams beside_reference(const Catalogue& catalogue, const Reference& reference, Grams grams) {
  std::vector<int> known;
  std::vector<Eigen::Index> at;
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    if (!is_shared(catalogue, column)) continue;
    const auto found = std::find(reference.column.begin(), reference.column.end(), name_of(catalogue, column));
    if (found == reference.column.end()) continue;
    known.push_back(c);
    at.push_back(found - reference.column.begin());
  }
  if (known.empty()) return grams;
  const Eigen::MatrixXd total = grams.total();
  Eigen::MatrixXd H = reference.information(at, at);
  H.diagonal().array() += decisions::reference_prior;
  const Eigen::MatrixXd sum = total(known, known) + H;
  const Eigen::VectorXd scale = sum.diagonal().cwiseMax(1e-18).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd unit = scale.asDiagonal() * sum * scale.asDiagonal();
  unit.diagonal().array() += 1e-10;
  const Eigen::MatrixXd error = scale.asDiagonal() * unit.ldlt().solve(scale.asDiagonal() * total(known, Eigen::all));
  // rows less what the errors of the known numbers explain of them, and the rows of the reference that these errors cost
  Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(total.cols(), total.cols());
  for (std::size_t i = 0; i < known.size(); ++i) rest.row(known[i]) -= error.row(static_cast<Eigen::Index>(i));
  for (Eigen::MatrixXd& block : grams.block) block = rest.transpose() * block * rest;
  grams.block.push_back(error.transpose() * H * error);
  grams.flight.push_back(0);
  grams.time_s.push_back(0.0);
  grams.cluster.push_back(grams.clusters++);
  return grams;
}

}  // namespace gustlab::diagnosis
