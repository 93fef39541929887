// What one candidate does along every flight beside what is known, and what the whole model leaves there.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gustlab::diagnosis {

// Whitened rows as they follow each other in time: [flight][channel], samples × (columns, z).
using RowSeries = std::vector<std::vector<Eigen::MatrixXd>>;

struct Signature {
  Eigen::MatrixXd by;    // samples × parameters, less what is known can do of it
  Eigen::VectorXd left;  // samples
};
using SignatureSeries = std::vector<std::vector<Signature>>;  // [flight][channel]

// Sums over all rows of products of columns (columns × columns, without z).
Eigen::MatrixXd column_products(const RowSeries& series);
// `products`: those of the series; `own`: columns of the candidate; `known`: columns that are free beside it; `coefficient`: of
// (known, own), fitted together.
SignatureSeries signature_series(const RowSeries& series, const Eigen::MatrixXd& products,
                                 const std::vector<int>& known, const std::vector<int>& own,
                                 const Eigen::VectorXd& coefficient);

}  // namespace gustlab::diagnosis
