#include <cmath>

#include "diagnosis/estimation/direct_forces.hpp"
#include "diagnosis/estimation/filter_pass.hpp"

namespace gustlab::diagnosis {

namespace {

// What the way back needs of a sample. A gain is that of a whitened innovation.
template <int size>
struct Step {
  static constexpr int slow = FilterPass<size>::slow;
  Eigen::Matrix<double, slow, size, Eigen::RowMajor> P;  // after the measurements, of the slow states
  Eigen::Matrix<double, slow, 1> x;
  int rows = 0;
  std::array<int, row_count> row;
  std::array<double, row_count> innovation, variance;  // whitened; before that
  Eigen::Matrix<double, row_count, size, Eigen::RowMajor> gain;
};

template <int size>
std::vector<Step<size>> filtered(FilterPass<size>& filter, const LinearFlight& flight) {
  const std::size_t n = flight.size();
  std::vector<Step<size>> steps(n);
  for (std::size_t k = 0; k < n; ++k) {
    if (flight.starts[k]) filter.start(k);
    filter.measure(k, [](int, double*) {});
    Step<size>& step = steps[k];
    step.P = filter.state().template bottomLeftCorner<Step<size>::slow, size>();
    step.x = -filter.state().col(filter.y_at).template tail<Step<size>::slow>();
    step.rows = static_cast<int>(filter.rows());
    for (Eigen::Index i = 0; i < filter.rows(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      step.row[at] = filter.row(i);
      step.innovation[at] = filter.innovations()(i, filter.y_at);
      step.variance[at] = filter.variance(i);
      step.gain.row(i) = filter.innovations().row(i).template head<size>();
    }
    if (k + 1 < n && !flight.starts[k + 1]) filter.advance(k);
  }
  return steps;
}

// Modified Bryson–Frazier: x_smooth = x − P λ, P_smooth = P − P Λ P; no inverse. λ and Λ come back from the end of a segment.
template <int size>
class WayBack {
 public:
  WayBack(const LinearFlight& flight, const NoiseModel& noise, FilterPass<size>& filter, Smoothed& out)
      : flight_(flight), noise_(noise), filter_(filter), out_(out) {}

  void forget() {
    lambda_.setZero();
    Lambda_.setZero();
  }

  // From before the measurements of sample k + 1 to after those of sample k.
  void retreat(std::size_t k) {
    for (int j = 0; j < 6; ++j) {
      // of white acceleration with variance q of what it changes: mean −q λ, second moment q + q² (λ² − Λ)
      const int at = white_row(j);
      const double power = noise_.white[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)])],
                   q = power * flight_.interval_s[k];
      out_.white[static_cast<std::size_t>(j)] += power + power * q * (lambda_[at] * lambda_[at] - Lambda_(at, at));
      out_.disturbance[k][j] = -power * lambda_[at];
    }
    filter_.set_transition(k);
    for (SparseRow& row : At_) row.size = 0;
    for (int i = 0; i < size; ++i) {
      const SparseRow& row = filter_.transition()[static_cast<std::size_t>(i)];
      for (std::size_t j = 0; j < static_cast<std::size_t>(row.size); ++j)
        At_[static_cast<std::size_t>(row.at[j])].add(i, row.value[j]);
    }
    next_ = lambda_;
    for (std::size_t i = 0; i < size; ++i) lambda_[static_cast<Eigen::Index>(i)] = At_[i].times(next_.data());
    multiply(At_.data(), size, Lambda_, product_, Lambda_.cols());
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < size; ++j) through_(j, i) = product_(i, j);  // Λ A
    multiply(At_.data(), size, through_, Lambda_, Lambda_.cols());
    for (int i = 0; i < size; ++i)
      for (int j = 0; j < i; ++j) Lambda_(i, j) = Lambda_(j, i);
  }

  // The slow states of a sample, and, when it was retreated to, with those of the next.
  void add_slow(std::size_t k, const Step<size>& step, bool linked) {
    product_.setZero();
    subtract_product(product_, 0, slow, step.P.data(), size, 1, Lambda_, size, Lambda_.cols());
    for (int j = 0; j < slow; ++j) {
      const auto at = static_cast<std::size_t>(j);
      const double mean = step.x[j] - step.P.row(j).dot(lambda_);
      const double variance = step.P(j, 12 + j) + step.P.row(j).dot(product_.row(j).template head<size>());
      const double second = mean * mean + variance;
      out_.second[at] += second;
      out_.count[at] += 1.0;
      if (!flight_.starts[k]) out_.later[at] += second;
      if (j < 6) out_.disturbance[k][j] += mean, out_.disturbance_variance[k][j] = variance;
      if (!linked) continue;
      const double decay = filter_.transition()[static_cast<std::size_t>(12 + j)].value[0], q = filter_.process(12 + j);
      const double mean_next = decay * mean - q * next_[12 + j];
      out_.lagged[at] +=
          mean_next * mean + decay * variance - q * through_.row(12 + j).template head<size>().dot(step.P.row(j));
      out_.earlier[at] += second;
      out_.pairs[at] += 1.0;
    }
  }

  // Back through the measurements of a sample, the last first: C = I − K h. The noise of a measurement has, smoothed, mean
  // R (e / S + K λ) and variance R − R² (1 / S + K Λ K) (Durbin and Koopman, Time Series Analysis, 2012, §4.5).
  void unmeasure(std::size_t k, const Step<size>& step) {
    for (int i = step.rows; i-- > 0;) {
      const auto at = static_cast<std::size_t>(i);
      const SparseRow h = FilterPass<size>::measurement_row(flight_, k, step.row[at]);
      const double sd = std::sqrt(step.variance[at]);
      const Vector K = step.gain.row(i).transpose() / sd;
      product_.row(0).setZero();
      subtract_product(product_, 0, 1, K.data(), 0, 1, Lambda_, size, Lambda_.cols());
      const Vector LK = -product_.row(0).template head<size>().transpose();
      const double correction = K.dot(lambda_) + step.innovation[at] / sd, square = K.dot(LK) + 1.0 / step.variance[at];
      const auto g = static_cast<std::size_t>(step.row[at] / 3);
      const double R = noise_.measurement[g];
      out_.residual[g] += R * R * (correction * correction - square) + R;
      out_.residual_count[g] += 1.0;
      for (std::size_t q = 0; q < static_cast<std::size_t>(h.size); ++q) {
        lambda_[h.at[q]] -= h.value[q] * correction;
        Lambda_.row(h.at[q]).template head<size>() -= h.value[q] * LK.transpose();
        Lambda_.col(h.at[q]) -= h.value[q] * LK;
      }
      for (std::size_t q = 0; q < static_cast<std::size_t>(h.size); ++q)
        for (std::size_t s = 0; s < static_cast<std::size_t>(h.size); ++s)
          Lambda_(h.at[q], h.at[s]) += h.value[q] * h.value[s] * square;
    }
  }

 private:
  static constexpr int slow = FilterPass<size>::slow;
  using Vector = Eigen::Matrix<double, size, 1>;
  const LinearFlight& flight_;
  const NoiseModel& noise_;
  FilterPass<size>& filter_;
  Smoothed& out_;
  Vector lambda_ = Vector::Zero(), next_ = lambda_;  // next: before it retreated
  Rows Lambda_ = Rows::Zero(size, padded(size)), product_ = Lambda_, through_ = Lambda_;
  std::array<SparseRow, size> At_;
};

template <int size>
Smoothed smooth_with(const LinearFlight& flight, const NoiseModel& noise) {
  const std::size_t n = flight.size();
  FilterPass<size> filter(flight, noise, 0);
  const std::vector<Step<size>> steps = filtered(filter, flight);
  Smoothed out;
  out.disturbance.assign(n, Eigen::Matrix<double, 6, 1>::Zero());
  out.disturbance_variance.resize(n);
  WayBack<size> back(flight, noise, filter, out);
  for (std::size_t k = n; k-- > 0;) {
    const bool linked = k + 1 < n && !flight.starts[k + 1];
    if (linked) back.retreat(k);
    else back.forget();
    back.add_slow(k, steps[k], linked);
    back.unmeasure(k, steps[k]);
  }
  return out;
}

}  // namespace

Smoothed smooth(const LinearFlight& flight, const NoiseModel& noise) {
  if (flight.forces_alone) return smooth_forces(flight);
  return noise.errors_last() ? smooth_with<state_size + row_count>(flight, noise)
                             : smooth_with<state_size>(flight, noise);
}

}  // namespace gustlab::diagnosis
