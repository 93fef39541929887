// Products of small matrices that are kept as rows. Every number of a row goes through the same operations in the same order, so
// that vectors of any width give the same bits: these run in the widest that the processor has, all else in those that every
// processor has.
#pragma once

#include <Eigen/Core>
#include <array>

namespace gustlab::diagnosis {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// the most numbers that are taken at once: the length of a row is a multiple of it
inline constexpr Eigen::Index pack_size = 8;
constexpr Eigen::Index padded(Eigen::Index columns) { return (columns + pack_size - 1) / pack_size * pack_size; }

// one row of a matrix: the few entries that are not zero
struct SparseRow {
  std::array<int, 13> at;
  std::array<double, 13> value;
  int size = 0;
  void add(int index, double v) {
    at[static_cast<std::size_t>(size)] = index;
    value[static_cast<std::size_t>(size++)] = v;
  }
  // Its product with a vector.
  double times(const double* vector) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(size); ++i) sum += value[i] * vector[at[i]];
    return sum;
  }
};

// out = A in, of the first `width` columns; both have rows of the same length.
void multiply(const SparseRow* A, Eigen::Index rows, const Rows& in, Rows& out, Eigen::Index width);
// Rows [first, first + rows) of `out` less C in, of the first `width` columns: C(r, i) = C[r * row_step + i * column_step],
// i < inner.
void subtract_product(Rows& out, Eigen::Index first, Eigen::Index rows, const double* C, Eigen::Index row_step,
                      Eigen::Index column_step, const Rows& in, Eigen::Index inner, Eigen::Index width);

// sum = rowsᵀ rows of the first `count` rows; columns of both are a multiple of pack_size.
void products_of_columns(const Rows& rows, Eigen::Index count, Rows& sum);

}  // namespace gustlab::diagnosis
