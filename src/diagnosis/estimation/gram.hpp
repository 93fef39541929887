// Whitened innovations as small Gram matrices, and every fit, comparison and resampling that is a sum and a solve of them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "diagnosis/estimation/innovations.hpp"

namespace gustlab::diagnosis {

// [Φ z]ᵀ[Φ z] per block of half a second, in catalogue columns plus z as the last.
struct Grams {
  std::vector<Eigen::MatrixXd> block;
  std::vector<int> flight;     // of each block
  std::vector<double> time_s;  // at which each block begins
  std::vector<int> cluster;    // blocks of one second belong together
  std::vector<bool> known;     // of each block: not flown, but known beforehand
  int clusters = 0;
  double rows = 0.0;  // whitened innovations that count, at 125 Hz at most
  int columns = 0;

  Eigen::MatrixXd total() const;
  // One more block, which is a cluster of its own. `is_known`: of what is known of a flight beforehand.
  void add(int flight, double time_s, Eigen::MatrixXd block, bool is_known);
  // z becomes z + Φ d: coefficients are then counted from θ₀ − d.
  void shift(const Eigen::VectorXd& d);
};
// Adds one flight's innovations; rows that are not warm do not count.
void accumulate(const Whitened& whitened, const std::vector<int>& columns, int flight, int catalogue_size,
                Grams& grams);

// Those of further flights.
void append(Grams&& more, Grams& grams);

// A column that is small beforehand: standard deviation in its natural unit.
struct Trim {
  int column;
  double deviation;
};

// Least squares on a Gram matrix: coefficients and what is left of zᵀz.
struct Fit {
  Eigen::VectorXd coefficient;
  double loss = 0.0;
};
Fit solve(const Eigen::MatrixXd& gram, const std::vector<int>& columns, double ridge = 1e-9);

// Solution X (n × m) of A X = right, A symmetric and not negative (n × n); `ridge` is added to every diagonal element in units of itself.
Eigen::MatrixXd solve_ridged(const Eigen::MatrixXd& A, const Eigen::MatrixXd& right, double ridge);

// The Gram matrix with some columns (always free) projected out of all others.
Eigen::MatrixXd project_out(const Eigen::MatrixXd& gram, const std::vector<int>& columns);

// Covariance of coefficients, robust against correlation within clusters (sandwich).
Eigen::MatrixXd clustered_covariance(const Grams& grams, const std::vector<int>& columns,
                                     const Eigen::VectorXd& coefficient);

// Variance of one coefficient, robust likewise: `pattern` is its column less what others say of it, `left` what the whole fit leaves
// (both as weights of the columns and z).
double clustered_variance(const Grams& grams, const Eigen::VectorXd& pattern, const Eigen::VectorXd& left);

// Loss per block at given coefficients.
Eigen::VectorXd block_losses(const Grams& grams, const std::vector<int>& columns, const Eigen::VectorXd& coefficient);

}  // namespace gustlab::diagnosis
