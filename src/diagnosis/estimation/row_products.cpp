#include "diagnosis/estimation/row_products.hpp"

#ifdef __x86_64__
#define GUSTLAB_WIDEST __attribute__((target("avx512f")))
#else
#define GUSTLAB_WIDEST
#endif
// sanitizers do not survive the choice of a function while the program is loaded
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define GUSTLAB_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define GUSTLAB_WIDE
#endif
#define GUSTLAB_WITHIN inline __attribute__((always_inline))

namespace gustlab::diagnosis {

namespace {

using Index = Eigen::Index;

bool takes_eight() {
#if defined(__x86_64__)
  static const bool takes = __builtin_cpu_supports("avx512f") != 0;
  return takes;
#else
  return false;
#endif
}

// Numbers that are taken at once. Eight where the processor does: elsewhere they would be split, and go through memory.
struct Four {
  static constexpr Index size = 4;
  using Pack = double __attribute__((vector_size(4 * sizeof(double)), aligned(sizeof(double)), may_alias));
};
struct Eight {
  static constexpr Index size = 8;
  using Pack = double __attribute__((vector_size(8 * sizeof(double)), aligned(sizeof(double)), may_alias));
};

template <class By>
const typename By::Pack* packs(const double* row) {
  return reinterpret_cast<const typename By::Pack*>(row);
}
template <class By>
typename By::Pack* packs(double* row) {
  return reinterpret_cast<typename By::Pack*>(row);
}

template <class By>
GUSTLAB_WITHIN void multiply_by(const SparseRow* A, Index rows, const Rows& in, Rows& out, Index width) {
  using Pack = typename By::Pack;
  const Index stride = in.cols(), last = width / By::size;
  for (Index r = 0; r < rows; ++r) {
    const SparseRow& row = A[r];
    Pack* to = packs<By>(out.data() + r * stride);
    Index c = 0;
    for (; c + 1 < last; c += 2) {
      Pack left = {}, right = {};
      for (int i = 0; i < row.size; ++i) {
        const Pack* from = packs<By>(in.data() + row.at[static_cast<std::size_t>(i)] * stride) + c;
        const double value = row.value[static_cast<std::size_t>(i)];
        left += value * from[0];
        right += value * from[1];
      }
      to[c] = left;
      to[c + 1] = right;
    }
    if (c == last) continue;
    Pack sum = {};
    for (int i = 0; i < row.size; ++i)
      sum += row.value[static_cast<std::size_t>(i)] *
             packs<By>(in.data() + row.at[static_cast<std::size_t>(i)] * stride)[c];
    to[c] = sum;
  }
}

template <class By>
GUSTLAB_WITHIN void subtract_product_by(Rows& out, Index first, Index rows, const double* C, Index row_step,
                                        Index column_step, const Rows& in, Index inner, Index width) {
  using Pack = typename By::Pack;
  constexpr Index together = 6;  // rows, each of which needs the same of `in`; states are a multiple of it
  for (Index c = 0; c < width / By::size; ++c) {
    const auto to = [&](Index r) { return packs<By>(out.data() + (first + r) * out.cols()) + c; };
    const auto from = [&](Index i) { return packs<By>(in.data() + i * in.cols()) + c; };
    Index r = 0;
    for (; r + together <= rows; r += together) {
      Pack sum[together];
#pragma GCC unroll 6
      for (Index q = 0; q < together; ++q) sum[q] = *to(r + q);
      for (Index i = 0; i < inner; ++i) {
        const Pack less = *from(i);
#pragma GCC unroll 6
        for (Index q = 0; q < together; ++q) sum[q] -= C[(r + q) * row_step + i * column_step] * less;
      }
#pragma GCC unroll 6
      for (Index q = 0; q < together; ++q) *to(r + q) = sum[q];
    }
    for (; r < rows; ++r) {
      Pack sum = *to(r);
      for (Index i = 0; i < inner; ++i) sum -= C[r * row_step + i * column_step] * *from(i);
      *to(r) = sum;
    }
  }
}

template <class By>
GUSTLAB_WITHIN void products_of_columns_by(const Rows& rows, Index count, Rows& sum) {
  using Pack = typename By::Pack;
  constexpr Index together = 4;  // columns by two packs, the packs below the diagonal by symmetry
  const Index stride = rows.cols(), last = stride / By::size;
  for (Index i = 0; i < stride; i += together)
    for (Index c = i / By::size; c < last; c += 2) {
      const bool two = c + 1 < last;
      Pack left[together] = {}, right[together] = {};
      const double* row = rows.data();
      for (Index k = 0; k < count; ++k, row += stride) {
        const Pack first = packs<By>(row)[c], second = packs<By>(row)[two ? c + 1 : c];
#pragma GCC unroll 4
        for (Index r = 0; r < together; ++r) {
          left[r] += row[i + r] * first;
          right[r] += row[i + r] * second;
        }
      }
      for (Index r = 0; r < together; ++r) {
        Pack* to = packs<By>(sum.data() + (i + r) * stride) + c;
        to[0] = left[r];
        if (two) to[1] = right[r];
      }
    }
  for (Index i = 0; i < stride; ++i)
    for (Index j = 0; j < i; ++j) sum(i, j) = sum(j, i);
}

GUSTLAB_WIDE void multiply_4(const SparseRow* A, Index rows, const Rows& in, Rows& out, Index width) {
  multiply_by<Four>(A, rows, in, out, width);
}
GUSTLAB_WIDEST void multiply_8(const SparseRow* A, Index rows, const Rows& in, Rows& out, Index width) {
  multiply_by<Eight>(A, rows, in, out, width);
}
GUSTLAB_WIDE void subtract_product_4(Rows& out, Index first, Index rows, const double* C, Index row_step,
                                     Index column_step, const Rows& in, Index inner, Index width) {
  subtract_product_by<Four>(out, first, rows, C, row_step, column_step, in, inner, width);
}
GUSTLAB_WIDEST void subtract_product_8(Rows& out, Index first, Index rows, const double* C, Index row_step,
                                       Index column_step, const Rows& in, Index inner, Index width) {
  subtract_product_by<Eight>(out, first, rows, C, row_step, column_step, in, inner, width);
}
GUSTLAB_WIDE void products_of_columns_4(const Rows& rows, Index count, Rows& sum) {
  products_of_columns_by<Four>(rows, count, sum);
}
GUSTLAB_WIDEST void products_of_columns_8(const Rows& rows, Index count, Rows& sum) {
  products_of_columns_by<Eight>(rows, count, sum);
}

}  // namespace

void multiply(const SparseRow* A, Eigen::Index rows, const Rows& in, Rows& out, Eigen::Index width) {
  (takes_eight() ? multiply_8 : multiply_4)(A, rows, in, out, width);
}

void subtract_product(Rows& out, Eigen::Index first, Eigen::Index rows, const double* C, Eigen::Index row_step,
                      Eigen::Index column_step, const Rows& in, Eigen::Index inner, Eigen::Index width) {
  (takes_eight() ? subtract_product_8 : subtract_product_4)(out, first, rows, C, row_step, column_step, in, inner,
                                                            width);
}

void products_of_columns(const Rows& rows, Eigen::Index count, Rows& sum) {
  (takes_eight() ? products_of_columns_8 : products_of_columns_4)(rows, count, sum);
}

}  // namespace gustlab::diagnosis
