#include "diagnosis/estimation/signature.hpp"

#include <Eigen/Cholesky>

namespace gustlab::diagnosis {

namespace {

Eigen::MatrixXd pick(const Eigen::MatrixXd& rows, const std::vector<int>& columns) { return rows(Eigen::all, columns); }

}  // namespace

SignatureSeries signature_series(const RowSeries& series, const std::vector<int>& known, const std::vector<int>& own,
                                 const Eigen::VectorXd& coefficient) {
  const auto k = static_cast<Eigen::Index>(known.size()), o = static_cast<Eigen::Index>(own.size());
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(k, k), cross = Eigen::MatrixXd::Zero(k, o);
  for (const auto& flight : series)
    for (const Eigen::MatrixXd& rows : flight) {
      const Eigen::MatrixXd free = pick(rows, known);
      gram += free.transpose() * free;
      cross += free.transpose() * pick(rows, own);
    }
  Eigen::MatrixXd on_known(k, o);
  if (k > 0) {
    gram.diagonal().array() += 1e-10 * (gram.diagonal().maxCoeff() + 1e-300);
    on_known = gram.ldlt().solve(cross);
  }
  SignatureSeries parts;
  for (const auto& flight : series) {
    auto& of_flight = parts.emplace_back();
    for (const Eigen::MatrixXd& rows : flight) {
      const Eigen::MatrixXd free = pick(rows, known), mine = pick(rows, own);
      of_flight.push_back({mine - free * on_known,
                           rows.col(rows.cols() - 1) - free * coefficient.head(k) - mine * coefficient.tail(o)});
    }
  }
  return parts;
}

}  // namespace gustlab::diagnosis
