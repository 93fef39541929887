// Whitened innovations as small Gram matrices, and every fit, comparison and resampling that is a sum and a solve of them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "diagnosis/estimation/innovations.hpp"
#include "diagnosis/estimation/row_products.hpp"

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
  // What so many numbers must gain of the loss (Schwarz, Ann. Stat. 6, 1978).
  double price(std::size_t numbers) const;
  // One more block, which is a cluster of its own. `is_known`: of what is known of a flight beforehand.
  void add(int flight, double time_s, Eigen::MatrixXd block, bool is_known);
  // See shifted() below.
  void shift(const Eigen::VectorXd& d);
};
// Adds one flight's innovations, which come in order of time; rows that are not warm do not count.
class GramBlocks {
 public:
  // `columns`: of the catalogue, those that the rows have; `one_block`: the sum of all blocks in place of each
  GramBlocks(std::vector<int> columns, int flight, int catalogue_size, Grams& grams, bool one_block = false);
  ~GramBlocks() { finish_block(); }
  GramBlocks(const GramBlocks&) = delete;
  GramBlocks& operator=(const GramBlocks&) = delete;
  // One whitened innovation: of every column, and of y.
  void add(double time_s, bool warm, const double* columns, double y);
  void add(const Whitened& whitened);

 private:
  void finish_block();
  std::vector<int> at_;  // columns and y in a block
  int flight_, last_cluster_ = -1, blocks_ = 0;
  bool one_block_;
  Grams& grams_;
  std::optional<double> start_s_;
  double begin_s_ = 0.0, block_ = 0.0;  // of the present block: its first row, its number
  Rows kept_;                           // its rows that count
  Eigen::Index count_ = 0;
};

// A Gram matrix of rows [Φ | z] whose z becomes z + Φ d: coefficients are then counted from θ₀ − d.
Eigen::MatrixXd shifted(Eigen::MatrixXd gram, const Eigen::VectorXd& d);

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
