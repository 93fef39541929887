#include "diagnosis/estimation/row_products.hpp"

// sanitizers do not survive the choice of a function while the program is loaded
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define GUSTLAB_WIDEST __attribute__((target_clones("avx2", "default")))
#else
#define GUSTLAB_WIDEST
#endif

namespace gustlab::diagnosis {

namespace {

using Pack = double __attribute__((vector_size(pack_size * sizeof(double)), aligned(sizeof(double)), may_alias));

const Pack* packs(const double* row) { return reinterpret_cast<const Pack*>(row); }
Pack* packs(double* row) { return reinterpret_cast<Pack*>(row); }

}  // namespace

GUSTLAB_WIDEST
void multiply(const SparseRow* A, Eigen::Index rows, const Rows& in, Rows& out, Eigen::Index width) {
  const Eigen::Index stride = in.cols(), last = width / pack_size;
  for (Eigen::Index r = 0; r < rows; ++r) {
    const SparseRow& row = A[r];
    Pack* to = packs(out.data() + r * stride);
    Eigen::Index c = 0;
    for (; c + 1 < last; c += 2) {
      Pack left = {}, right = {};
      for (int i = 0; i < row.size; ++i) {
        const Pack* from = packs(in.data() + row.at[static_cast<std::size_t>(i)] * stride) + c;
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
      sum +=
          row.value[static_cast<std::size_t>(i)] * packs(in.data() + row.at[static_cast<std::size_t>(i)] * stride)[c];
    to[c] = sum;
  }
}

GUSTLAB_WIDEST
void subtract_product(Rows& out, Eigen::Index first, Eigen::Index rows, const double* C, Eigen::Index row_step,
                      Eigen::Index column_step, const Rows& in, Eigen::Index inner, Eigen::Index width) {
  const Eigen::Index last = width / pack_size;
  // a few columns of `in` at a time, so that they stay near
  Eigen::Index c = 0;
  for (; c + 1 < last; c += 2)
    for (Eigen::Index r = 0; r < rows; ++r) {
      Pack* to = packs(out.data() + (first + r) * out.cols()) + c;
      Pack left = to[0], right = to[1];
      for (Eigen::Index i = 0; i < inner; ++i) {
        const Pack* from = packs(in.data() + i * in.cols()) + c;
        const double value = C[r * row_step + i * column_step];
        left -= value * from[0];
        right -= value * from[1];
      }
      to[0] = left;
      to[1] = right;
    }
  if (c == last) return;
  for (Eigen::Index r = 0; r < rows; ++r) {
    Pack& to = packs(out.data() + (first + r) * out.cols())[c];
    Pack sum = to;
    for (Eigen::Index i = 0; i < inner; ++i)
      sum -= C[r * row_step + i * column_step] * packs(in.data() + i * in.cols())[c];
    to = sum;
  }
}

GUSTLAB_WIDEST
void products_of_columns(const Rows& rows, Eigen::Index count, Rows& sum) {
  const Eigen::Index stride = rows.cols(), last = stride / pack_size;
  // four columns by two packs at a time, the packs below the diagonal by symmetry
  for (Eigen::Index i = 0; i < stride; i += pack_size)
    for (Eigen::Index c = i / pack_size; c < last; c += 2) {
      const bool two = c + 1 < last;
      Pack left[pack_size] = {}, right[pack_size] = {};
      const double* row = rows.data();
      for (Eigen::Index k = 0; k < count; ++k, row += stride) {
        const Pack first = packs(row)[c], second = packs(row)[two ? c + 1 : c];
        for (Eigen::Index r = 0; r < pack_size; ++r) {
          left[r] += row[i + r] * first;
          right[r] += row[i + r] * second;
        }
      }
      for (Eigen::Index r = 0; r < pack_size; ++r) {
        Pack* to = packs(sum.data() + (i + r) * stride) + c;
        to[0] = left[r];
        if (two) to[1] = right[r];
      }
    }
  for (Eigen::Index i = 0; i < stride; ++i)
    for (Eigen::Index j = 0; j < i; ++j) sum(i, j) = sum(j, i);
}

}  // namespace gustlab::diagnosis
