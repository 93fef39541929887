#include "diagnosis/estimation/torque_trims.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "diagnosis/result/decisions.hpp"

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
  std::map<int, std::pair<double, Eigen::MatrixXd>> known;  // of each flight: where it begins
  for (std::size_t b = 0; b < grams.block.size(); ++b)
    known.try_emplace(grams.flight[b], grams.time_s[b], Eigen::MatrixXd::Zero(z + 1, z + 1));
  for (Eigen::Index c = 0; c < z; ++c) {
    const Column& column = catalogue.column(c);
    const double sd = known_to(column, variance);
    const auto of_flight = known.find(std::max(column.flight, 0));
    if (sd == 0.0 || of_flight == known.end()) continue;
    const Eigen::Vector2d row = file_row(column, sd, value[c]);
    Eigen::MatrixXd& block = of_flight->second.second;
    block(c, c) += row[0] * row[0];
    block(c, z) += row[0] * row[1], block(z, c) += row[0] * row[1];
    block(z, z) += row[1] * row[1];
  }
  for (auto& [flight, of_flight] : known) grams.add(flight, of_flight.first, std::move(of_flight.second), true);
}

TrimVariance usual_trims(const VehicleModel& vehicle) {
  const double moment_Nm = decisions::usual_shift * vehicle.arm_m() * vehicle.mass_kg * vehicle.gravity_mps2;
  TrimVariance variance{};
  for (int axis = 0; axis < 3; ++axis)
    variance[static_cast<std::size_t>(axis)] = std::pow(moment_Nm / vehicle.inertia_B_kgm2(axis, axis), 2);
  return variance;
}

TrimVariance likeliest_trims(const Catalogue& catalogue, const std::vector<int>& columns, const Eigen::VectorXd& value,
                             const Grams& grams, const TrimVariance& usual, TrimVariance variance) {
  const double flights = static_cast<double>(std::set<int>(grams.flight.begin(), grams.flight.end()).size());
  if (flights < 2.0) return variance;
  const Eigen::MatrixXd total = grams.total();
  const auto size = std::ssize(columns);
  std::vector<Eigen::Index> trims;
  for (Eigen::Index i = 0; i < size; ++i)
    if (catalogue.column(columns[static_cast<std::size_t>(i)]).of_torque_trim()) trims.push_back(i);
  for (int step = 0; step < steps; ++step) {
    // the columns and, of each axis, what all flights share
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size + 3, size + 3),
                    right = Eigen::MatrixXd::Zero(size + 3, 1 + std::ssize(trims));
    A.topLeftCorner(size, size) = total(columns, columns);
    right.col(0).head(size) = total(columns, total.cols() - 1);
    std::size_t t = 0;
    for (Eigen::Index i = 0; i < size; ++i) {
      const int c = columns[static_cast<std::size_t>(i)];
      const Column& column = catalogue.column(c);
      const double sd = known_to(column, variance);
      if (sd == 0.0) continue;
      Eigen::VectorXd row = Eigen::VectorXd::Zero(size + 3);
      const Eigen::Vector2d own = file_row(column, sd, value[c]);
      row[i] = own[0];
      if (column.of_torque_trim()) {
        row[size + column.parameter - torque_trim] = -1.0 / sd;
        right.col(static_cast<Eigen::Index>(++t)) = sd * row;
      }
      A += row * row.transpose();
      right.col(0) += own[1] * row;
    }
    const Eigen::MatrixXd solution = solve_ridged(A, right, 1e-9);
    TrimVariance next = usual;
    for (t = 0; t < trims.size(); ++t) {
      const int c = columns[static_cast<std::size_t>(trims[t])];
      const auto beyond = right.col(static_cast<Eigen::Index>(t) + 1);
      const double mean = value[c] + beyond.dot(solution.col(0)),
                   own = beyond.dot(solution.col(static_cast<Eigen::Index>(t) + 1));
      next[static_cast<std::size_t>(catalogue.column(c).parameter - torque_trim)] += mean * mean + own;
    }
    for (double& v : next) v /= flights + 1.0;
    variance = next;
  }
  return variance;
}

}  // namespace gustlab::diagnosis
