// One pass of the Kalman filter along a flight. The covariance, what is measured and every column of a regression are columns of
// one block with a row per state: all go through the same two steps, a product with the transition and a downdate by whitened
// innovations. Whitened one after the other, rows of a sample are scalar measurements (Bierman, Factorization Methods, 1977, §V.2).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "diagnosis/estimation/noise_model.hpp"
#include "diagnosis/estimation/row_products.hpp"

namespace gustlab::diagnosis {

// the state of the disturbance that moves an error: force its position and velocity, torque its attitude and rate
inline int mover(int error) { return 12 + error % 3 + (error < 6 ? 0 : 3); }

// what the white acceleration of an axis changes: velocity, body rate
inline int white_row(int axis) { return axis < 3 ? 3 + axis : 6 + axis; }

// A state is the error state, the disturbance, and, where errors of the sensors last, these.
template <int size>
class FilterPass {
 public:
  static constexpr int slow = size - error_size;
  static constexpr Eigen::Index y_at = size, first_column = size + 1;

  // `columns`: beside y
  FilterPass(const LinearFlight& flight, const NoiseModel& noise, Eigen::Index columns)
      : flight_(flight),
        noise_(noise),
        state_(Rows::Zero(size, padded(first_column + columns))),
        next_(state_),
        innovation_(Rows::Zero(row_count, state_.cols())) {
    std::array<std::array<bool, 12>, 12> acts{};
    for (const Matrix12& F : flight.F)
      for (int j = 0; j < 12; ++j)
        for (int i = 0; i < 12; ++i) acts[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] |= F(i, j) != 0.0;
    for (std::size_t i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j)
        if (acts[i][static_cast<std::size_t>(j)]) acting_[i].push_back(j);
  }

  // Forgets everything before sample k.
  void start(std::size_t k) {
    // how far the smoothed trajectory may be from the truth at the start of a segment (Crazyflie to Iris)
    constexpr std::array<double, 4> prior_variance = {4e-6, 4e-3, 4e-4, 4e-2};
    state_.setZero();
    for (int i = 0; i < 12; ++i) state_(i, i) = prior_variance[static_cast<std::size_t>(i / 3)];
    // what is never measured is not known to a millimetre
    if (!flight_.measured[k][0])
      for (int i = 0; i < 6; ++i) state_(i, i) = 1.0;
    if (!flight_.measured[k][3])
      for (int i = 6; i < 9; ++i) state_(i, i) = 0.25;
    for (int i = 0; i < slow; ++i) state_(12 + i, 12 + i) = memory(i).first;
  }

  // Takes in the measurements of sample k. `add(row, e)` adds to an innovation, before it is whitened, what its columns are at no
  // error of the state; e[first_column] is the first.
  template <class Add>
  void measure(std::size_t k, const Add& add) {
    count_ = 0;
    for (int r = 0; r < row_count; ++r) {
      if (!flight_.measured[k][r]) continue;
      row_[count_] = r;
      H_[count_++] = measurement_row(flight_, k, r);
    }
    multiply(H_.data(), rows(), state_, innovation_, state_.cols());
    for (std::size_t i = 0; i < count_; ++i) {
      double* e = innovation_.data() + static_cast<Eigen::Index>(i) * state_.cols();
      e[y_at] += flight_.y[k][row_[i]];
      add(row_[i], e);
      std::array<double, row_count> known;  // of this row, by those before
      for (std::size_t j = 0; j < i; ++j)
        known[j] = H_[i].times(innovation_.data() + static_cast<Eigen::Index>(j) * state_.cols());
      subtract_product(innovation_, static_cast<Eigen::Index>(i), 1, known.data(), 0, 1, innovation_,
                       static_cast<Eigen::Index>(i), state_.cols());
      variance_[i] = noise_.measurement[static_cast<std::size_t>(row_[i] / 3)] + H_[i].times(e);
      innovation_.row(static_cast<Eigen::Index>(i)) *= 1.0 / std::sqrt(variance_[i]);
    }
    subtract_product(state_, 0, size, innovation_.data(), 1, state_.cols(), innovation_, rows(), state_.cols());
  }

  // On to sample k + 1. `add(row, x)` adds to the rows of velocity and position what accelerations change.
  void advance(std::size_t k) {
    set_transition(k);
    multiply(A_.data(), size, state_, next_, padded(size));
    // P⁺ = A (A P)ᵀ, and everything else once
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < size; ++j) state_(j, i) = next_(i, j);
    multiply(A_.data(), size, state_, next_, state_.cols());
    state_.swap(next_);
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < i; ++j) state_(i, j) = state_(j, i);
      state_(i, i) += process_[static_cast<std::size_t>(i)];
    }
    state_.template block<12, 1>(0, y_at) -= flight_.b[k];
  }

  // The transition from sample k to the next, and the variance that it adds.
  void set_transition(std::size_t k) {
    const double dt = flight_.interval_s[k];
    process_.fill(1e-14);
    for (int i = 0; i < 12; ++i) {
      SparseRow& row = A_[static_cast<std::size_t>(i)];
      row.size = 0;
      for (const int j : acting_[static_cast<std::size_t>(i)]) row.add(j, flight_.F[k](i, j));
      row.add(mover(i), i % 6 < 3 ? 0.5 * dt * dt : dt);
    }
    double decay = 0.0, variance = 0.0;
    for (int i = 0; i < slow; ++i) {
      const auto at = static_cast<std::size_t>(12 + i);
      // axes of one group are alike
      if (i == 0 || memory(i) != memory(i - 1)) {
        decay = std::exp(-dt / memory(i).second);
        variance = memory(i).first * (1.0 - decay * decay);
      }
      A_[at].size = 0;
      A_[at].add(12 + i, decay);
      process_[at] += variance;
    }
    for (int i = 0; i < 6; ++i)
      process_[static_cast<std::size_t>(white_row(i))] +=
          noise_.white[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(i)])] * dt;
    // torques unknown: the rotation is free, so that only forces count
    if (!flight_.torque_known) std::fill_n(process_.begin() + 9, 3, 1e4 * dt);
  }

  // P in the first columns, then what is measured (less the mean of the state), then the columns
  Rows& state() { return state_; }
  // of the last sample, whitened: [gain of every state | y | columns]
  const Rows& innovations() const { return innovation_; }
  Eigen::Index rows() const { return static_cast<Eigen::Index>(count_); }
  int row(Eigen::Index i) const { return row_[static_cast<std::size_t>(i)]; }
  double variance(Eigen::Index i) const { return variance_[static_cast<std::size_t>(i)]; }
  const std::array<SparseRow, size>& transition() const { return A_; }
  double process(int state) const { return process_[static_cast<std::size_t>(state)]; }

  static SparseRow measurement_row(const LinearFlight& flight, std::size_t k, int row) {
    SparseRow h;
    if (size > state_size) h.add(state_size + row, 1.0);
    if (row < 3) {
      h.add(row, 1.0);
      // the logged origin turns about the centre of mass: δ(−R r) = R [r]× δϑ
      const Vector3& r = flight.center_of_mass_B_m;
      if (!r.isZero(0.0))
        for (int i = 0; i < 3; ++i) h.add(6 + i, -flight.R_WB[k].row(row).dot(Vector3::Unit(i).cross(r)));
    } else if (row < 9) {
      h.add(3 + row, 1.0);
    } else {
      for (int i = 0; i < 9; ++i) h.add(3 + i, flight.force_rows[k](row - 9, i));
      for (int i = 0; i < 3; ++i) h.add(12 + i, flight.R_WB[k](i, row - 9));
    }
    return h;
  }

 private:
  // of a slow part: variance and correlation time
  std::pair<double, double> memory(int part) const {
    if (part >= 6)
      return {noise_.lasting_variance[static_cast<std::size_t>(part / 3 - 2)],
              noise_.lasting_time_s[static_cast<std::size_t>(part / 3 - 2)]};
    const auto g = static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(part)]);
    return {noise_.variance[g], noise_.time_s[g]};
  }

  const LinearFlight& flight_;
  const NoiseModel& noise_;
  std::array<std::vector<int>, 12> acting_;  // columns of F that are not zero all along the flight
  Rows state_, next_, innovation_;
  std::array<SparseRow, size> A_;
  std::array<double, size> process_;
  std::array<SparseRow, row_count> H_;
  std::array<int, row_count> row_;
  std::array<double, row_count> variance_;
  std::size_t count_ = 0;
};

}  // namespace gustlab::diagnosis
