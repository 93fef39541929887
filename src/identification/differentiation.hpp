// Derivatives of sampled signals, smoothing, and the cutting of edges. One row per sample, one column per signal.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>

namespace gustlab {

// Three-point difference of second order on any grid: central inside, one-sided with three points at both ends
// (Fornberg, Math. Comp. 51, 1988). At least 3 samples. Units of `values` per second.
Eigen::MatrixXd finite_difference(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& values);

// Least-squares polynomial of `degree` through `window` samples (odd) around each one, at the ends through the first or
// last `window` (Savitzky, Golay, Anal. Chem. 36, 1964); on an uneven grid at the true times.
// derivative 0: the smoothed values; 1: per second.
Eigen::MatrixXd savitzky_golay(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& values, int window, int degree,
                               int derivative);

// Mean over `window` samples (odd) centred on each one; near the ends over as many as fit symmetrically.
Eigen::MatrixXd running_mean(const Eigen::MatrixXd& values, int window);

// First row and number of rows that are left when `edge_s` seconds are cut off at both ends.
std::pair<Eigen::Index, Eigen::Index> trimmed_rows(const Eigen::VectorXd& time_s, double edge_s);

enum class DerivativeKind { finite_difference, savitzky_golay };
DerivativeKind derivative_kind(std::string_view name);  // throws ConfigError without a place
std::string_view to_string(DerivativeKind kind);

// How a recorded signal becomes a smooth one and its derivative.
struct Differentiation {
  DerivativeKind kind = DerivativeKind::finite_difference;
  int smoothing_window = 1;  // samples of the running mean that comes first, odd; 1: none
  int window = 11;           // samples, Savitzky–Golay only
  int degree = 3;            // Savitzky–Golay only
  double edge_s = 0.0;       // s cut off at both ends

  // Throws ConfigError when a number makes no sense.
  void check() const;
  Eigen::MatrixXd smooth(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& values) const;
  // Derivative of the raw values, smoothing included.
  Eigen::MatrixXd derivative(const Eigen::VectorXd& time_s, const Eigen::MatrixXd& values) const;
};

}  // namespace gustlab
