#include "diagnosis/validation/dependence.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/validation/generic_bases.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::block_s;
constexpr Eigen::Index fewest_blocks = 30, first_shift = 4;
constexpr double ridge = 30.0;  // of columns with unit deviation, in blocks

// how well a basis predicts y (two axes): −log of the share of its squares that is left
struct Projection {
  Eigen::MatrixXd basis;
  Eigen::LDLT<Eigen::MatrixXd> normal;

  explicit Projection(const std::vector<Eigen::VectorXd>& rows)
      : basis(static_cast<Eigen::Index>(rows.size()), rows.front().size() + 1) {
    for (Eigen::Index i = 0; i < basis.rows(); ++i) basis.row(i) << 0.0, rows[static_cast<std::size_t>(i)].transpose();
    for (Eigen::Index c = 1; c < basis.cols(); ++c) {
      basis.col(c).array() -= basis.col(c).mean();
      basis.col(c) /= std::sqrt(basis.col(c).squaredNorm() / static_cast<double>(basis.rows())) + 1e-12;
    }
    basis.col(0).setOnes();
    Eigen::MatrixXd gram = basis.transpose() * basis;
    gram.diagonal().array() += ridge;
    normal.compute(gram);
  }
  double predicted(const Eigen::MatrixXd& y) const {
    const Eigen::MatrixXd left = y - basis * normal.solve(basis.transpose() * y);
    return -std::log((left.squaredNorm() + 1e-300) / (y.squaredNorm() + 1e-300));
  }
};

}  // namespace

Eigen::VectorXd moved_along(const Eigen::VectorXd& y, const std::vector<int>& flight, Eigen::Index shift) {
  Eigen::VectorXd moved(y.size());
  for (Eigen::Index first = 0; first < y.size();) {
    Eigen::Index last = first;
    while (last < y.size() && flight[static_cast<std::size_t>(last)] == flight[static_cast<std::size_t>(first)]) ++last;
    for (Eigen::Index i = first; i < last; ++i) moved[i] = y[first + (i - first + shift) % (last - first)];
    first = last;
  }
  return moved;
}

bool depends_on_state(const Session& session, const std::vector<Smoothed>& smoothed) {
  const auto length = static_cast<std::size_t>(std::max(1.0, std::round(block_s / session.sample_s())));
  const FlownVolume volume(session);
  std::vector<int> flight;
  std::vector<Eigen::VectorXd> place, velocity;
  std::vector<Eigen::Vector2d> force;
  for (std::size_t f = 0; f < session.flights().size(); ++f) {
    const std::vector<Motion>& motion = session.flights()[f].motion;
    for (std::size_t first = 0; first + length <= motion.size(); first += length) {
      Eigen::VectorXd p = PlaceFunctions::Zero(), v = Eigen::VectorXd::Zero(6);
      Eigen::Vector2d d = Eigen::Vector2d::Zero();
      for (std::size_t k = first; k < first + length; ++k) {
        p += volume.functions(motion[k].position_W_m);
        v.head<3>() += motion[k].velocity_W_mps;
        v.tail<3>() += motion[k].velocity_W_mps.norm() * motion[k].velocity_W_mps;
        d += smoothed[f].disturbance[k].head<2>();
      }
      flight.push_back(static_cast<int>(f));
      place.push_back(p), velocity.push_back(v), force.push_back(d);
    }
  }
  const auto rows = static_cast<Eigen::Index>(flight.size());
  if (rows < fewest_blocks) return false;
  Eigen::MatrixXd y(rows, 2);
  for (Eigen::Index i = 0; i < rows; ++i) y.row(i) = force[static_cast<std::size_t>(i)].transpose();
  for (int axis = 0; axis < 2; ++axis) y.col(axis).array() -= y.col(axis).mean();
  const Eigen::Index shortest = rows / static_cast<Eigen::Index>(session.flights().size());
  for (const auto* of : {&place, &velocity}) {
    const Projection projection(*of);
    const auto predicted = [&](Eigen::Index shift) {
      Eigen::MatrixXd moved(rows, 2);
      for (int axis = 0; axis < 2; ++axis) moved.col(axis) = moved_along(y.col(axis), flight, shift);
      return projection.predicted(moved);
    };
    std::vector<double> chance;
    for (Eigen::Index shift = first_shift; shift + first_shift <= shortest; ++shift) chance.push_back(predicted(shift));
    const Eigen::Map<const Eigen::VectorXd> moved(chance.data(), static_cast<Eigen::Index>(chance.size()));
    const double sd = std::sqrt((moved.array() - moved.mean()).square().mean());
    if (predicted(0) > moved.mean() + decisions::surely_dependent * sd) return true;
  }
  return false;
}

}  // namespace gustlab::diagnosis
