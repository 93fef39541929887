// Products of rows against Eigen's dense ones, of every width that a pack leaves over.
#include "diagnosis/estimation/row_products.hpp"

#include <gtest/gtest.h>

#include "gustlab/random.hpp"

namespace gustlab::diagnosis {
namespace row_products_test {

constexpr Eigen::Index states = 7;

Rows random_rows(Eigen::Index rows, Eigen::Index columns, const char* stream) {
  const RandomStream random(11, 0, stream);
  Rows out(rows, columns);
  for (Eigen::Index i = 0; i < out.size(); ++i) out.data()[i] = random.normal4(static_cast<std::uint64_t>(i))[0];
  return out;
}

// rows with one to five entries
struct Sparse {
  std::array<SparseRow, states> rows;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(states, states);

  Sparse() {
    const Rows values = random_rows(states, states, "sparse");
    for (int r = 0; r < states; ++r)
      for (int c = r % 2; c < states; c += 1 + r % 3) {
        rows[static_cast<std::size_t>(r)].add(c, values(r, c));
        dense(r, c) = values(r, c);
      }
  }
};

TEST(RowProducts, PaddedIsTheNextWholePack) {
  EXPECT_EQ(padded(0), 0);
  EXPECT_EQ(padded(1), pack_size);
  EXPECT_EQ(padded(pack_size), pack_size);
  EXPECT_EQ(padded(pack_size + 1), 2 * pack_size);
}

TEST(RowProducts, OfASparseRowAndAVector) {
  const Sparse A;
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(states, -1.0, 2.0);
  for (int r = 0; r < states; ++r)
    EXPECT_NEAR(A.rows[static_cast<std::size_t>(r)].times(x.data()), A.dense.row(r).dot(x), 1e-14);
}

// one pack is left over of an odd number of them; what lies beyond the width stays as it was
TEST(RowProducts, MultiplyIsTheDenseProductOfTheFirstColumns) {
  const Sparse A;
  for (const Eigen::Index width : {0, 8, 16, 24, 32, 40}) {
    const Rows in = random_rows(states, 40, "in"), before = random_rows(states, 40, "out");
    Rows out = before;
    multiply(A.rows.data(), states, in, out, width);
    const Eigen::MatrixXd dense = A.dense * in.leftCols(width);
    EXPECT_LT((out.leftCols(width) - dense).cwiseAbs().sum(), 1e-12) << width;
    EXPECT_EQ(out.rightCols(40 - width), before.rightCols(40 - width)) << width;
  }
}

TEST(RowProducts, SubtractedProductIsTheDenseOneInEitherOrderOfC) {
  constexpr Eigen::Index inner = 5, first = 2, rows = 11;
  const Rows C = random_rows(rows, inner, "C");
  const Rows turned = C.transpose();
  for (const Eigen::Index width : {0, 8, 16, 24, 40}) {
    const Rows in = random_rows(inner, 40, "in"), before = random_rows(first + rows, 40, "out");
    Eigen::MatrixXd dense = before;
    dense.block(first, 0, rows, width) -= C * in.leftCols(width);
    Rows by_row = before, by_column = before;
    subtract_product(by_row, first, rows, C.data(), inner, 1, in, inner, width);
    subtract_product(by_column, first, rows, turned.data(), 1, rows, in, inner, width);
    EXPECT_LT((by_row - dense).cwiseAbs().sum(), 1e-12) << width;
    EXPECT_EQ(by_row, by_column) << width;
  }
}

// whatever the processor takes at once: each number alone, one product after the other
TEST(RowProducts, HaveTheBitsOfOneNumberAtATime) {
  constexpr Eigen::Index inner = 5, rows = 8, width = 24;  // six rows together, and two left over
  const Rows C = random_rows(rows, inner, "C"), in = random_rows(inner, width, "in");
  Rows expected = random_rows(rows, width, "out"), out = expected;
  for (Eigen::Index r = 0; r < rows; ++r)
    for (Eigen::Index c = 0; c < width; ++c)
      for (Eigen::Index i = 0; i < inner; ++i) expected(r, c) -= C(r, i) * in(i, c);
  subtract_product(out, 0, rows, C.data(), inner, 1, in, inner, width);
  EXPECT_EQ(out, expected);

  Rows sum = Rows::Zero(width, width), alone = sum;
  for (Eigen::Index i = 0; i < width; ++i)
    for (Eigen::Index j = 0; j < width; ++j)
      for (Eigen::Index k = 0; k < inner; ++k) alone(i, j) += in(k, i) * in(k, j);
  products_of_columns(in, inner, sum);
  EXPECT_EQ(sum, alone);
}

// a column has the same bits wherever it stands and whatever stands beside it
TEST(RowProducts, ColumnsDoNotKnowTheirNeighbours) {
  const Sparse A;
  const Rows in = random_rows(states, 24, "in");
  Rows wide = Rows::Zero(states, 24);
  multiply(A.rows.data(), states, in, wide, 24);
  const Rows C = random_rows(states, states, "C");
  subtract_product(wide, 0, states, C.data(), states, 1, in, states, 24);
  for (Eigen::Index c = 0; c < 24; ++c) {
    Rows alone = Rows::Zero(states, pack_size), out = alone;
    alone.col(1) = in.col(c);
    multiply(A.rows.data(), states, alone, out, pack_size);
    subtract_product(out, 0, states, C.data(), states, 1, alone, states, pack_size);
    EXPECT_EQ(out.col(1), wide.col(c)) << c;
  }
}

}  // namespace row_products_test
}  // namespace gustlab::diagnosis
