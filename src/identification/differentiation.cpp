#include "identification/differentiation.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "gustlab/errors.hpp"

namespace gustlab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd finite_difference(const VectorXd& time_s, const MatrixXd& values) {
  const Index n = values.rows();
  if (n < 3 || time_s.size() != n)
    throw DataError("a derivative needs at least 3 samples (there are " + std::to_string(n) + ")");
  MatrixXd out(n, values.cols());
  for (Index i = 0; i < n; ++i) {
    // derivative at t_i of the parabola through three neighbouring samples
    const Index first = std::clamp<Index>(i - 1, 0, n - 3);
    const double a = time_s[first] - time_s[i], b = time_s[first + 1] - time_s[i], c = time_s[first + 2] - time_s[i];
    out.row(i) = values.row(first) * (-(b + c) / ((a - b) * (a - c))) +
                 values.row(first + 1) * (-(a + c) / ((b - a) * (b - c))) +
                 values.row(first + 2) * (-(a + b) / ((c - a) * (c - b)));
  }
  return out;
}

MatrixXd savitzky_golay(const VectorXd& time_s, const MatrixXd& values, int window, int degree, int derivative) {
  const Index n = values.rows();
  if (n < window || time_s.size() != n) {
    throw DataError("a window of " + std::to_string(window) + " samples does not fit (there are " + std::to_string(n) +
                    ")");
  }
  MatrixXd out(n, values.cols());
  MatrixXd powers(window, degree + 1);
  for (Index i = 0; i < n; ++i) {
    // weights of the window's samples in the polynomial's value or slope at t_i, times scaled to stay near one
    const Index first = std::clamp<Index>(i - window / 2, 0, n - window);
    const double scale = time_s[first + window - 1] - time_s[first];
    for (Index k = 0; k < window; ++k) {
      double power = 1.0;
      for (int d = 0; d <= degree; ++d, power *= (time_s[first + k] - time_s[i]) / scale) powers(k, d) = power;
    }
    VectorXd wanted = VectorXd::Zero(degree + 1);
    wanted[derivative] = derivative == 0 ? 1.0 : 1.0 / scale;
    const Eigen::HouseholderQR<MatrixXd> qr(powers);
    const auto triangle = qr.matrixQR().topRows(degree + 1).triangularView<Eigen::Upper>();
    VectorXd weights = VectorXd::Zero(window);
    weights.head(degree + 1) = triangle.transpose().solve(wanted);
    weights.applyOnTheLeft(qr.householderQ());
    out.row(i) = weights.transpose() * values.middleRows(first, window);
  }
  return out;
}

MatrixXd running_mean(const MatrixXd& values, int window) {
  const Index n = values.rows();
  MatrixXd out(n, values.cols());
  for (Index i = 0; i < n; ++i) {
    const Index reach = std::min<Index>({window / 2, i, n - 1 - i});
    out.row(i) = values.middleRows(i - reach, 2 * reach + 1).colwise().mean();
  }
  return out;
}

std::pair<Index, Index> trimmed_rows(const VectorXd& time_s, double edge_s) {
  if (time_s.size() == 0) return {0, 0};
  const double* begin = time_s.data();
  const double* end = begin + time_s.size();
  const double* first = std::lower_bound(begin, end, time_s[0] + edge_s);
  const double* last = std::upper_bound(begin, end, time_s[time_s.size() - 1] - edge_s);
  return {first - begin, std::max<Index>(0, last - first)};
}

DerivativeKind derivative_kind(std::string_view name) {
  for (DerivativeKind kind : {DerivativeKind::finite_difference, DerivativeKind::savitzky_golay}) {
    if (name == to_string(kind)) return kind;
  }
  throw ConfigError("unknown differentiation \"" + std::string(name) + "\"; use finite_difference or savitzky_golay");
}

std::string_view to_string(DerivativeKind kind) {
  return kind == DerivativeKind::finite_difference ? "finite_difference" : "savitzky_golay";
}

void Differentiation::check() const {
  if (smoothing_window < 1 || smoothing_window % 2 == 0) {
    throw ConfigError("smoothing window " + std::to_string(smoothing_window) +
                      " (must be odd and positive); use 1 for none");
  }
  if (window < 3 || window % 2 == 0 || degree < 1 || degree >= window) {
    throw ConfigError("Savitzky-Golay window " + std::to_string(window) + ", degree " + std::to_string(degree) +
                      " (the window must be odd and longer than the degree, which is at least 1); use 11 and 3");
  }
  if (!(edge_s >= 0.0) || !std::isfinite(edge_s)) throw ConfigError("edge must be a finite time of at least 0 s");
}

MatrixXd Differentiation::smooth(const VectorXd& time_s, const MatrixXd& values) const {
  const MatrixXd mean = running_mean(values, smoothing_window);
  return kind == DerivativeKind::savitzky_golay ? savitzky_golay(time_s, mean, window, degree, 0) : mean;
}

MatrixXd Differentiation::derivative(const VectorXd& time_s, const MatrixXd& values) const {
  const MatrixXd mean = running_mean(values, smoothing_window);
  return kind == DerivativeKind::savitzky_golay ? savitzky_golay(time_s, mean, window, degree, 1)
                                                : finite_difference(time_s, mean);
}

}  // namespace gustlab
