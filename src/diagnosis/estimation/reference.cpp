#include "diagnosis/estimation/reference.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "diagnosis/result/decisions.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

// numbers that a vehicle has: not those of one flight, and no history that a scan of these flights found
bool is_shared(const Catalogue& catalogue, const Column& column) {
  return column.group >= 0 && column.flight < 0 && !catalogue.group(column.group).row->is_history();
}

std::pair<std::string, int> name_of(const Catalogue& catalogue, const Column& column) {
  return {catalogue.group(column.group).label, column.parameter};
}

int flights_of(const Grams& grams) { return 1 + std::ranges::max(grams.flight); }

// Gram matrices of each flight; of one alone, of its thirds in time
std::vector<Eigen::MatrixXd> parts_of(const Grams& grams) {
  const bool one = flights_of(grams) == 1;
  const std::size_t count = one ? 3 : static_cast<std::size_t>(flights_of(grams));
  double first_s = std::numeric_limits<double>::infinity(), last_s = -first_s;
  for (std::size_t b = 0; b < grams.block.size(); ++b)
    if (!grams.known[b]) first_s = std::min(first_s, grams.time_s[b]), last_s = std::max(last_s, grams.time_s[b]);
  const double third_s = std::max((last_s - first_s) / 3.0, 1e-9);
  std::vector<Eigen::MatrixXd> parts(count, Eigen::MatrixXd::Zero(grams.columns + 1, grams.columns + 1));
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    const double third = grams.known[b] ? 0.0 : std::clamp((grams.time_s[b] - first_s) / third_s, 0.0, 2.0);
    parts[static_cast<std::size_t>(one ? static_cast<int>(third) : grams.flight[b])] += grams.block[b];
  }
  return parts;
}

// The covariance of the score of all flights at what they say together: where the model holds it is their information H. What flights differ by
// beyond chance is added, in the directions in which they differ: a wind of its own leaves a gyroscope's scale as sure as it is, and numbers that
// flights hardly tell apart (a mass, a thrust scale) keep what they say together. Few flights differ in few directions: what they usually differ by,
// the median over the numbers, counts in all.
Eigen::MatrixXd score_covariance(const Grams& grams, const std::vector<int>& free, const std::vector<int>& shared,
                                 const Eigen::MatrixXd& H, const Eigen::VectorXd& estimate) {
  const std::vector<Eigen::MatrixXd> parts = parts_of(grams);
  const double count = static_cast<double>(parts.size());
  Eigen::MatrixXd differ = Eigen::MatrixXd::Zero(H.rows(), H.cols());
  for (const Eigen::MatrixXd& part : parts) {
    const Eigen::MatrixXd own = project_out(part, free), A = own(shared, shared);
    const Eigen::VectorXd score = own(shared, own.cols() - 1) - A * estimate;
    differ += count / (count - 1.0) * score * score.transpose();
  }
  const Eigen::ArrayXd ratio = differ.diagonal().array() / (H.diagonal().array() + 1e-12);
  const double usual = std::max(1.0, median({ratio.begin(), ratio.end()})),
               by_chance = usual * solve_ridged(H, H, 1e-6).trace(), all = solve_ridged(H, differ, 1e-6).trace();
  return usual * H + std::max(0.0, 1.0 - by_chance / (all + 1e-12)) * differ;
}

}  // namespace

Reference reference_of(const Catalogue& catalogue, const Grams& grams, const std::vector<int>& free) {
  std::vector<int> shared;
  Reference reference;
  reference.flights = flights_of(grams);
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    if (!is_shared(catalogue, column)) continue;
    shared.push_back(c);
    reference.column.push_back(name_of(catalogue, column));
  }
  const Eigen::MatrixXd total = project_out(grams.total(), free);
  const Eigen::MatrixXd H = total(shared, shared);
  Eigen::MatrixXd with_prior = H;
  with_prior.diagonal().array() += decisions::reference_prior;
  reference.estimate = with_prior.ldlt().solve(total(shared, total.cols() - 1));
  reference.information = H * solve_ridged(score_covariance(grams, free, shared, H, reference.estimate), H, 1e-8);
  return reference;
}

KnownColumns known_columns(const Catalogue& catalogue, const std::vector<int>& present, const Reference& reference) {
  KnownColumns known;
  for (const int c : present) {
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

Grams beside_reference(const Catalogue& catalogue, const std::vector<int>& present, const Reference& reference,
                       Grams grams) {
  const KnownColumns columns = known_columns(catalogue, present, reference);
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
