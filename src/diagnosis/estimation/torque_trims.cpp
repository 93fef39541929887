#include "diagnosis/estimation/torque_trims.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

namespace gustlab::diagnosis {

namespace {

constexpr int steps = 12;
constexpr double least_share = 1e-6;  // of the variance that trims have beforehand

std::vector<int> trims_among(const Catalogue& catalogue, const std::vector<int>& columns) {
  std::vector<int> trims;
  std::ranges::copy_if(columns, std::back_inserter(trims),
                       [&](int c) { return catalogue.columns()[static_cast<std::size_t>(c)].of_torque_trim(); });
  return trims;
}

// one more measurement of a trim, which says zero: [its column | z]
Eigen::Vector2d zero_row(const Column& column, const TrimVariance& variance, double value) {
  const double sd = std::sqrt(std::max(variance[static_cast<std::size_t>(column.parameter - torque_trim)],
                                       least_share * column.natural * column.natural));
  return Eigen::Vector2d(column.natural, -value) / sd;
}

}  // namespace

void know_trims(const Catalogue& catalogue, const TrimVariance& variance, const Eigen::VectorXd& value, Grams& grams) {
  std::vector<int> all(static_cast<std::size_t>(catalogue.size()));
  for (std::size_t c = 0; c < all.size(); ++c) all[c] = static_cast<int>(c);
  const Eigen::Index z = catalogue.size();
  for (const int c : trims_among(catalogue, all)) {
    const Column& column = catalogue.columns()[static_cast<std::size_t>(c)];
    const Eigen::Vector2d row = zero_row(column, variance, value[c]);
    const auto first = std::ranges::find(grams.flight, column.flight);
    if (first == grams.flight.end()) continue;
    Eigen::MatrixXd& block = grams.block[static_cast<std::size_t>(first - grams.flight.begin())];
    block(c, c) += row[0] * row[0];
    block(c, z) += row[0] * row[1], block(z, c) += row[0] * row[1];
    block(z, z) += row[1] * row[1];
  }
}

TrimVariance likeliest_trims(const Catalogue& catalogue, const std::vector<int>& columns, const Eigen::VectorXd& value,
                             const Grams& grams, TrimVariance variance) {
  const std::vector<int> trims = trims_among(catalogue, columns);
  const double flights = static_cast<double>(std::set<int>(grams.flight.begin(), grams.flight.end()).size());
  if (flights < 2.0) return {};
  const Eigen::MatrixXd total = grams.total();
  const Eigen::Index z = total.cols() - 1;
  for (int step = 0; step < steps; ++step) {
    Eigen::MatrixXd A = total(columns, columns);
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(A.rows(), 1 + std::ssize(trims));
    right.col(0) = total(columns, z);
    std::vector<Eigen::Index> at;
    for (const int c : trims) {
      const Eigen::Index i = std::ranges::find(columns, c) - columns.begin();
      const Eigen::Vector2d row = zero_row(catalogue.columns()[static_cast<std::size_t>(c)], variance, value[c]);
      A(i, i) += row[0] * row[0];
      right(i, 0) += row[0] * row[1];
      right(i, 1 + std::ssize(at)) = 1.0;
      at.push_back(i);
    }
    const Eigen::MatrixXd solution = solve_ridged(A, right, 1e-9);
    TrimVariance next{};
    for (std::size_t t = 0; t < trims.size(); ++t) {
      const Column& column = catalogue.columns()[static_cast<std::size_t>(trims[t])];
      const double mean = value[trims[t]] + column.natural * solution(at[t], 0),
                   own = column.natural * column.natural * solution(at[t], static_cast<Eigen::Index>(t) + 1);
      next[static_cast<std::size_t>(column.parameter - torque_trim)] += (mean * mean + own) / flights;
    }
    variance = next;
  }
  return variance;
}

}  // namespace gustlab::diagnosis
