#include "diagnosis/estimation/signature.hpp"

#include <Eigen/Cholesky>

namespace gustlab::diagnosis {

Eigen::MatrixXd column_products(const RowSeries& series) {
  Eigen::MatrixXd sum;
  for (const auto& flight : series)
    for (const Eigen::MatrixXd& rows : flight) {
      const auto columns = rows.leftCols(rows.cols() - 1);
      if (sum.size() == 0) sum = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
      sum.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
    }
  return sum.selfadjointView<Eigen::Lower>();
}

SignatureSeries signature_series(const RowSeries& series, const Eigen::MatrixXd& products,
                                 const std::vector<int>& known, const std::vector<int>& own,
                                 const Eigen::VectorXd& coefficient) {
  const auto k = static_cast<Eigen::Index>(known.size()), o = static_cast<Eigen::Index>(own.size());
  // weights of the columns and z: one column for each of its own, and one for what is left
  Eigen::MatrixXd weight = Eigen::MatrixXd::Zero(products.cols() + 1, o + 1);
  if (k > 0) {
    Eigen::MatrixXd gram = products(known, known);
    gram.diagonal().array() += 1e-10 * (gram.diagonal().maxCoeff() + 1e-300);
    weight(known, Eigen::seqN(0, o)) = -gram.ldlt().solve(products(known, own));
  }
  weight(known, o) = -coefficient.head(k);
  weight(own, o) = -coefficient.tail(o);
  weight(products.cols(), o) = 1.0;
  for (Eigen::Index i = 0; i < o; ++i) weight(own[static_cast<std::size_t>(i)], i) += 1.0;
  SignatureSeries parts;
  for (const auto& flight : series) {
    auto& of_flight = parts.emplace_back();
    for (const Eigen::MatrixXd& rows : flight) {
      const Eigen::MatrixXd weighed = rows * weight;
      of_flight.push_back({weighed.leftCols(o), weighed.col(o)});
    }
  }
  return parts;
}

}  // namespace gustlab::diagnosis
