#include "diagnosis/estimation/reference.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "diagnosis/result/decisions.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr double of_all = 3.0;  // flights

// numbers that a vehicle has: not those of one flight, and no history that a scan of these flights found
bool is_shared(const Catalogue& catalogue, const Column& column) {
  return column.group >= 0 && column.flight < 0 && !catalogue.group(column.group).row->is_history();
}

std::pair<std::string, int> name_of(const Catalogue& catalogue, const Column& column) {
  return {catalogue.group(column.group).label, column.parameter};
}

bool has_one_flight(const Grams& grams) {
  return std::ranges::all_of(grams.flight, [](int flight) { return flight == 0; });
}

// Gram matrices of each flight; of one alone, of its thirds
std::vector<Eigen::MatrixXd> parts_of(const Grams& grams) {
  const bool one = has_one_flight(grams);
  const std::size_t count = one ? 3 : static_cast<std::size_t>(std::ranges::max(grams.flight)) + 1,
                    size = grams.block.size();
  std::vector<Eigen::MatrixXd> parts(count, Eigen::MatrixXd::Zero(grams.columns + 1, grams.columns + 1));
  for (std::size_t b = 0; b < size; ++b)
    parts[!one ? static_cast<std::size_t>(grams.flight[b]) : grams.known[b] ? 0 : 3 * b / size] += grams.block[b];
  return parts;
}

// By how much parts of the flights differ in each number more than their noise lets them, at least 1: the squares of their scores at what
// all of them say together, over what they are where the model holds (a score of information A has the covariance A; a part of n counts
// 1 − 1/n). What a wind of its own changes in one number leaves the others as sure as they are. Few flights agree by chance: the median of all
// numbers counts as three flights more.
Eigen::ArrayXd differ_by(const Grams& grams, const std::vector<int>& free, const std::vector<int>& shared,
                         const Eigen::VectorXd& estimate) {
  const std::vector<Eigen::MatrixXd> parts = parts_of(grams);
  Eigen::ArrayXd squares = Eigen::ArrayXd::Zero(estimate.size()), expected = squares;
  for (const Eigen::MatrixXd& part : parts) {
    const Eigen::MatrixXd own = project_out(part, free), A = own(shared, shared);
    squares += (own(shared, own.cols() - 1) - A * estimate).array().square();
    expected += A.diagonal().array();
  }
  const double free_flights = static_cast<double>(parts.size()) - 1.0;
  const Eigen::ArrayXd ratio = squares / (expected * free_flights / (free_flights + 1.0) + 1e-12);
  const double usual = median({ratio.begin(), ratio.end()});
  return ((free_flights * ratio + of_all * usual) / (free_flights + of_all)).max(1.0);
}

}  // namespace

Reference reference_of(const Catalogue& catalogue, const Grams& grams, const std::vector<int>& free) {
  std::vector<int> shared;
  Reference reference;
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    if (!is_shared(catalogue, column)) continue;
    shared.push_back(c);
    reference.column.push_back(name_of(catalogue, column));
  }
  const Eigen::MatrixXd total = project_out(grams.total(), free);
  reference.information = total(shared, shared);
  Eigen::MatrixXd H = reference.information;
  H.diagonal().array() += decisions::reference_prior;
  reference.estimate = H.ldlt().solve(total(shared, total.cols() - 1));
  const Eigen::VectorXd less = differ_by(grams, free, shared, reference.estimate).sqrt().inverse();
  reference.information = less.asDiagonal() * reference.information * less.asDiagonal();
  return reference;
}

KnownColumns known_columns(const Catalogue& catalogue, const Reference& reference) {
  KnownColumns known;
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    if (!is_shared(catalogue, column)) continue;
    const auto found = std::find(reference.column.begin(), reference.column.end(), name_of(catalogue, column));
    if (found == reference.column.end()) continue;
    known.column.push_back(c);
    known.at.push_back(found - reference.column.begin());
  }
  return known;
}

namespace {

Eigen::MatrixXd held_beforehand(const Reference& reference, const KnownColumns& known) {
  Eigen::MatrixXd H = reference.information(known.at, known.at);
  H.diagonal().array() += decisions::reference_prior;
  return H;
}

}  // namespace

Eigen::VectorXd known_errors(const Reference& reference, const KnownColumns& known, const Eigen::MatrixXd& information,
                             const Eigen::VectorXd& score) {
  const Eigen::MatrixXd H = held_beforehand(reference, known);
  return solve_ridged(information + H, score + H * reference.estimate(known.at), 1e-10);
}

Grams beside_reference(const Catalogue& catalogue, const Reference& reference, Grams grams) {
  const KnownColumns columns = known_columns(catalogue, reference);
  const std::vector<int>& known = columns.column;
  if (known.empty()) return grams;
  Eigen::VectorXd estimate = Eigen::VectorXd::Zero(catalogue.size());
  estimate(known) = reference.estimate(columns.at);
  grams.shift(-estimate);
  const Eigen::MatrixXd total = grams.total();
  const Eigen::MatrixXd H = held_beforehand(reference, columns);
  const Eigen::MatrixXd error = solve_ridged(total(known, known) + H, total(known, Eigen::all), 1e-10);
  // rows less what the errors of the known numbers explain of them, and the rows of the reference that these errors cost
  Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(total.cols(), total.cols());
  for (std::size_t i = 0; i < known.size(); ++i) rest.row(known[i]) -= error.row(static_cast<Eigen::Index>(i));
  for (Eigen::MatrixXd& block : grams.block) block = rest.transpose() * block * rest;
  // rows of flights, and no more known than these
  grams.add(0, 0.0, error.transpose() * H * error, false);
  return grams;
}

}  // namespace gustlab::diagnosis
