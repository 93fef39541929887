#include "diagnosis/estimation/torque_trims.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

namespace gustlab::diagnosis {

namespace {

constexpr int steps = 12;
constexpr double least_share = 1e-6;  // of the variance that trims have beforehand

// what is known of a column beforehand: its standard deviation, SI; 0: nothing
double known_to(const Column& column, const TrimVariance& variance) {
  if (!column.of_torque_trim()) return column.known_to;
  return std::sqrt(std::max(variance[static_cast<std::size_t>(column.parameter - torque_trim)],
                            least_share * column.natural * column.natural));
}

// one more measurement of a column, which says what the vehicle file says: [its column | z]
Eigen::Vector2d file_row(const Column& column, double known_to, double value) {
  return Eigen::Vector2d(column.natural, column.nominal - value) / known_to;
}

}  // namespace

void know_beforehand(const Catalogue& catalogue, const TrimVariance& variance, const Eigen::VectorXd& value,
                     Grams& grams) {
  const Eigen::Index z = catalogue.size();
  for (Eigen::Index c = 0; c < z; ++c) {
    const Column& column = catalogue.column(c);
    const double sd = known_to(column, variance);
    const auto first = std::ranges::find(grams.flight, std::max(column.flight, 0));
    if (sd == 0.0 || first == grams.flight.end()) continue;
    const Eigen::Vector2d row = file_row(column, sd, value[c]);
    Eigen::MatrixXd& block = grams.block[static_cast<std::size_t>(first - grams.flight.begin())];
    block(c, c) += row[0] * row[0];
    block(c, z) += row[0] * row[1], block(z, c) += row[0] * row[1];
    block(z, z) += row[1] * row[1];
  }
}

TrimVariance likeliest_trims(const Catalogue& catalogue, const std::vector<int>& columns, const Eigen::VectorXd& value,
                             const Grams& grams, TrimVariance variance) {
  const double flights = static_cast<double>(std::set<int>(grams.flight.begin(), grams.flight.end()).size());
  if (flights < 2.0) return variance;
  const Eigen::MatrixXd total = grams.total();
  const auto size = std::ssize(columns);
  std::vector<Eigen::Index> trims;
  for (Eigen::Index i = 0; i < size; ++i)
    if (catalogue.column(columns[static_cast<std::size_t>(i)]).of_torque_trim()) trims.push_back(i);
  for (int step = 0; step < steps; ++step) {
    Eigen::MatrixXd A = total(columns, columns), right = Eigen::MatrixXd::Zero(size, 1 + std::ssize(trims));
    right.col(0) = total(columns, total.cols() - 1);
    for (Eigen::Index i = 0; i < size; ++i) {
      const int c = columns[static_cast<std::size_t>(i)];
      const Column& column = catalogue.column(c);
      const double sd = known_to(column, variance);
      if (sd == 0.0) continue;
      const Eigen::Vector2d row = file_row(column, sd, value[c]);
      A(i, i) += row[0] * row[0];
      right(i, 0) += row[0] * row[1];
    }
    for (std::size_t t = 0; t < trims.size(); ++t) right(trims[t], static_cast<Eigen::Index>(t) + 1) = 1.0;
    const Eigen::MatrixXd solution = solve_ridged(A, right, 1e-9);
    TrimVariance next{};
    for (std::size_t t = 0; t < trims.size(); ++t) {
      const int c = columns[static_cast<std::size_t>(trims[t])];
      const Column& column = catalogue.column(c);
      const double mean = value[c] + column.natural * solution(trims[t], 0),
                   own = column.natural * column.natural * solution(trims[t], static_cast<Eigen::Index>(t) + 1);
      next[static_cast<std::size_t>(column.parameter - torque_trim)] += (mean * mean + own) / flights;
    }
    variance = next;
  }
  return variance;
}

}  // namespace gustlab::diagnosis
