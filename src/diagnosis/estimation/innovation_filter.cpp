#include "diagnosis/estimation/innovation_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnosis/estimation/direct_forces.hpp"

namespace gustlab::diagnosis {

namespace {

// A state is the error state, the disturbance, and, where errors of the sensors last, these.
template <int size>
using Square = Eigen::Matrix<double, size, size>;
template <int size>
using Vector = Eigen::Matrix<double, size, 1>;
template <int size>
constexpr int slow = size - error_size;

// how far the smoothed trajectory may be from the truth at the start of a segment (Crazyflie to Iris)
constexpr std::array<double, 4> prior_variance = {4e-6, 4e-3, 4e-4, 4e-2};

// one row of H: the few entries that are not zero
struct Row {
  std::array<int, 13> at;
  std::array<double, 13> value;
  int size = 0;
  void add(int index, double v) {
    at[static_cast<std::size_t>(size)] = index;
    value[static_cast<std::size_t>(size++)] = v;
  }
};

template <int size>
Row measurement_row(const LinearFlight& flight, std::size_t k, int row) {
  Row h;
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

int noise_group(int row) { return row / 3; }

// the state of the disturbance that moves an error: force its position and velocity, torque its attitude and rate
int mover(int error) { return 12 + error % 3 + (error < 6 ? 0 : 3); }

// what the white acceleration of an axis changes: velocity, body rate
int white_row(int axis) { return axis < 3 ? 3 + axis : 6 + axis; }

// of a slow part: variance and correlation time
std::pair<double, double> memory(const NoiseModel& noise, int part) {
  if (part >= 6) return {noise.lasting_variance[static_cast<std::size_t>(part / 3 - 2)], noise.lasting_time_s[static_cast<std::size_t>(part / 3 - 2)]};
  const auto g = static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(part)]);
  return {noise.variance[g], noise.time_s[g]};
}

// transition of a state over one interval
template <int size>
struct Transition {
  Square<size> A;
  Vector<size> process;  // variance added
};

template <int size>
void transition(const LinearFlight& flight, std::size_t k, const NoiseModel& noise, Transition<size>& out) {
  const double dt = flight.interval_s[k];
  out.A.setZero();
  out.A.template topLeftCorner<12, 12>() = flight.F[k];
  for (int i = 0; i < 12; ++i) out.A(i, mover(i)) = i % 6 < 3 ? 0.5 * dt * dt : dt;
  out.process.setConstant(1e-14);
  for (int i = 0; i < slow<size>; ++i) {
    const auto [variance, time_s] = memory(noise, i);
    const double decay = std::exp(-dt / time_s);
    out.A(12 + i, 12 + i) = decay;
    out.process[12 + i] = variance * (1.0 - decay * decay);
  }
  for (int i = 0; i < 6; ++i) out.process[white_row(i)] += noise.white[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(i)])] * dt;
  // torques unknown: the rotation is free, so that only forces tell
  if (!flight.torque_known) out.process.template segment<3>(9).setConstant(1e4 * dt);
}

template <int size>
void start(const NoiseModel& noise, Square<size>& P, const LinearFlight& flight, std::size_t k) {
  P.setZero();
  for (int i = 0; i < 12; ++i) P(i, i) = prior_variance[static_cast<std::size_t>(i / 3)];
  // what is never measured is not known to a millimetre
  if (!flight.measured[k][0])
    for (int i = 0; i < 6; ++i) P(i, i) = 1.0;
  if (!flight.measured[k][3])
    for (int i = 6; i < 9; ++i) P(i, i) = 0.25;
  for (int i = 0; i < slow<size>; ++i) P(12 + i, 12 + i) = memory(noise, i).first;
}

// [F Γ] M, where Γ moves only the error's own axis: two entries a column
template <int size, int columns>
Eigen::Matrix<double, 12, columns> upper_times(const Transition<size>& t, const Eigen::Matrix<double, size, columns>& M) {
  const Matrix12 F = t.A.template topLeftCorner<12, 12>();
  Eigen::Matrix<double, 12, columns> result = F.lazyProduct(M.template topRows<12>());
  for (int i = 0; i < 12; ++i) result.row(i) += t.A(i, mover(i)) * M.row(mover(i));
  return result;
}

// M A of the same A
template <int size>
Square<size> times(const Square<size>& M, const Transition<size>& t) {
  const Matrix12 F = t.A.template topLeftCorner<12, 12>();
  Square<size> result;
  result.template leftCols<12>() = M.template leftCols<12>().lazyProduct(F);
  result.template rightCols<slow<size>>() = M.template rightCols<slow<size>>() * t.A.diagonal().template tail<slow<size>>().asDiagonal();
  for (int i = 0; i < 12; ++i) result.col(mover(i)) += t.A(i, mover(i)) * M.col(i);
  return result;
}

// P⁺ = A P Aᵀ + process, with A's lower-left block zero and its lower-right diagonal
template <int size>
void propagate(const Transition<size>& t, Square<size>& P) {
  constexpr int rest = slow<size>;
  const Eigen::Matrix<double, 12, size> upper = upper_times<size, size>(t, P);
  const Vector<rest> decay = t.A.diagonal().template tail<rest>();
  P.template bottomRightCorner<rest, rest>() = decay.asDiagonal() * P.template bottomRightCorner<rest, rest>() * decay.asDiagonal();
  P.template topRightCorner<12, rest>() = upper.template rightCols<rest>() * decay.asDiagonal();
  P.template bottomLeftCorner<rest, 12>() = P.template topRightCorner<12, rest>().transpose();
  const Matrix12 corner = upper_times<size, 12>(t, upper.transpose());
  P.template topLeftCorner<12, 12>() = 0.5 * (corner + corner.transpose());
  P.diagonal() += t.process;
}

template <int size>
Whitened whiten_with(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise, const std::vector<Pushes>* extra) {
  const std::size_t n = flight.size();
  const auto own = static_cast<Eigen::Index>(flight.columns.size());
  const Eigen::Index more = extra ? (*extra)[0].cols() : 0;
  const Eigen::Index width = own + more + 1;
  Whitened out;
  out.rows.resize(static_cast<Eigen::Index>(n * row_count), width);

  Square<size> P = Square<size>::Zero();
  using Columns = Eigen::Matrix<double, size, Eigen::Dynamic, Eigen::RowMajor>;
  Columns X = Columns::Zero(size, width);
  Transition<size> t;
  Eigen::RowVectorXd e(width);
  Eigen::Matrix<double, 3, Eigen::Dynamic> extra_felt;
  Vector<size> gain;
  Eigen::Index row_index = 0;
  std::size_t since_start = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if (flight.starts[k]) {
      start(noise, P, flight, k);
      X.setZero();
      since_start = 0;
    }
    if (more > 0 && flight.measured[k].tail<3>().any()) extra_felt = felt((*extra)[k], flight.R_WB[k]);
    for (int r = 0; r < row_count; ++r) {
      if (!flight.measured[k][r]) continue;
      const Row h = measurement_row<size>(flight, k, r);
      gain.setZero();
      // the last column is y − h x; the others D − h ξ, with ξ driven by −B … signs alike: innovation of a column
      e.setZero();
      for (int i = 0; i < h.size; ++i) {
        const auto at = h.at[static_cast<std::size_t>(i)];
        const double v = h.value[static_cast<std::size_t>(i)];
        gain += v * P.col(at);
        e += v * X.row(at);
      }
      if (own > 0) e.head(own) += flight.D[k].row(r);
      if (more > 0 && r >= first_force_row) e.segment(own, more) += extra_felt.row(r - first_force_row);
      e[width - 1] = flight.y[k][r] - e[width - 1];
      double variance = noise.measurement[static_cast<std::size_t>(noise_group(r))];
      for (int i = 0; i < h.size; ++i)
        variance += h.value[static_cast<std::size_t>(i)] * gain[h.at[static_cast<std::size_t>(i)]];
      const double sd = std::sqrt(variance);
      out.rows.row(row_index) = e / sd;
      out.minus_two_log_likelihood += 2.0 * std::log(sd) + out.rows(row_index, width - 1) * out.rows(row_index, width - 1);
      out.time_s.push_back(data.samples[k].time_s);
      out.channel.push_back(r);
      out.warm.push_back(since_start >= 20);
      ++row_index;
      gain /= variance;
      e[width - 1] = -e[width - 1];
      for (int i = 0; i < size; ++i) X.row(i) -= gain[i] * e;
      P -= gain * (variance * gain.transpose());
    }
    ++since_start;
    if (k + 1 == n || flight.starts[k + 1]) continue;
    transition(flight, k, noise, t);
    Columns next(size, width);
    next.template topRows<12>().noalias() = t.A.template topLeftCorner<12, state_size>() * X.template topRows<state_size>();
    next.template bottomRows<slow<size>>() = t.A.diagonal().template tail<slow<size>>().asDiagonal() * X.template bottomRows<slow<size>>();
    if (own > 0) next.topLeftCorner(12, own) += flight.B[k];
    if (more > 0) next.block(0, own, 12, more) += moved_by((*extra)[k], flight.interval_s[k]);
    next.col(width - 1).template head<12>() += flight.b[k];
    X.swap(next);
    propagate(t, P);
  }
  out.rows.conservativeResize(row_index, Eigen::NoChange);
  return out;
}

template <int size>
Smoothed smooth_with(const LinearFlight& flight, const NoiseModel& noise) {
  const std::size_t n = flight.size();
  struct Step {
    Vector<size> x;                 // after the measurements of this sample
    Square<size> P;
    Vector<size> x_before;
    Square<size> P_before;          // before them
    int rows = 0;
    std::array<double, row_count> innovation, variance;
    std::array<int, row_count> row;
    std::array<Vector<size>, row_count> gain;
  };
  std::vector<Step> steps(n);
  Vector<size> x = Vector<size>::Zero();
  Square<size> P = Square<size>::Zero();
  Transition<size> t;
  for (std::size_t k = 0; k < n; ++k) {
    Step& step = steps[k];
    if (flight.starts[k]) {
      start(noise, P, flight, k);
      x.setZero();
    }
    step.x_before = x;
    step.P_before = P;
    for (int r = 0; r < row_count; ++r) {
      if (!flight.measured[k][r]) continue;
      const Row h = measurement_row<size>(flight, k, r);
      Vector<size> gain = Vector<size>::Zero();
      double e = flight.y[k][r];
      for (int i = 0; i < h.size; ++i) {
        gain += h.value[static_cast<std::size_t>(i)] * P.col(h.at[static_cast<std::size_t>(i)]);
        e -= h.value[static_cast<std::size_t>(i)] * x[h.at[static_cast<std::size_t>(i)]];
      }
      double variance = noise.measurement[static_cast<std::size_t>(noise_group(r))];
      for (int i = 0; i < h.size; ++i)
        variance += h.value[static_cast<std::size_t>(i)] * gain[h.at[static_cast<std::size_t>(i)]];
      gain /= variance;
      const auto at = static_cast<std::size_t>(step.rows++);
      step.innovation[at] = e;
      step.variance[at] = variance;
      step.row[at] = r;
      step.gain[at] = gain;
      x += gain * e;
      P -= gain * (variance * gain.transpose());
    }
    step.x = x;
    step.P = P;
    if (k + 1 == n || flight.starts[k + 1]) continue;
    transition(flight, k, noise, t);
    x = t.A * x;
    x.template head<12>() += flight.b[k];
    propagate(t, P);
  }

  // modified Bryson–Frazier: x_smooth = x − P λ, P_smooth = P − P Λ P; no inverse
  Smoothed out;
  out.disturbance.assign(n, Eigen::Matrix<double, 6, 1>::Zero());
  out.disturbance_variance.resize(n);
  Vector<size> lambda = Vector<size>::Zero();
  Square<size> Lambda = Square<size>::Zero();
  for (std::size_t k = n; k-- > 0;) {
    const Step& step = steps[k];
    const bool linked = k + 1 < n && !flight.starts[k + 1];
    if (!linked) {
      lambda.setZero();
      Lambda.setZero();
    } else {
      // here λ, Λ are of sample k + 1 before its measurements
      transition(flight, k, noise, t);
      const Vector<size> lambda_next = lambda;
      const Square<size> Lambda_next = Lambda;
      lambda = t.A.transpose() * lambda_next;
      Lambda = times<size>(times<size>(Lambda_next, t).transpose(), t);
      Lambda = (0.5 * (Lambda + Lambda.transpose())).eval();
      for (int j = 0; j < slow<size>; ++j) {
        // Cov(d_{k+1}, d_k | all) = [A P_k]_{jj} − P⁻_{k+1} Λ_{k+1} A P_k
        const Vector<size> through = t.A * step.P.col(12 + j);
        const double covariance = through[12 + j] - steps[k + 1].P_before.row(12 + j) * (Lambda_next * through);
        const double mean_next = steps[k + 1].x_before[12 + j] - steps[k + 1].P_before.row(12 + j).dot(lambda_next);
        const double mean = step.x[12 + j] - step.P.row(12 + j).dot(lambda);
        out.lagged[static_cast<std::size_t>(j)] += mean_next * mean + covariance;
        out.pairs[static_cast<std::size_t>(j)] += 1.0;
        if (j >= 6) continue;
        // of white acceleration with variance q of what it changes: mean −q λ, second moment q + q² (λ² − Λ)
        const int at = white_row(j);
        const double power = noise.white[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)])], q = power * flight.interval_s[k];
        out.white[static_cast<std::size_t>(j)] += power + power * q * (lambda_next[at] * lambda_next[at] - Lambda_next(at, at));
        out.disturbance[k][j] = -power * lambda_next[at];
      }
    }
    for (int j = 0; j < slow<size>; ++j) {
      const double mean = step.x[12 + j] - step.P.row(12 + j).dot(lambda);
      const double variance = step.P(12 + j, 12 + j) - step.P.row(12 + j) * Lambda * step.P.col(12 + j);
      if (j < 6) out.disturbance[k][j] += mean, out.disturbance_variance[k][j] = variance;
      out.second[static_cast<std::size_t>(j)] += mean * mean + variance;
      out.count[static_cast<std::size_t>(j)] += 1.0;
    }
    const Vector<size> smoothed = step.x - step.P * lambda;
    for (int i = 0; i < step.rows; ++i) {
      const int r = step.row[static_cast<std::size_t>(i)];
      const Row h = measurement_row<size>(flight, k, r);
      double residual = flight.y[k][r];
      Vector<size> Ph = Vector<size>::Zero();
      for (int q = 0; q < h.size; ++q) {
        residual -= h.value[static_cast<std::size_t>(q)] * smoothed[h.at[static_cast<std::size_t>(q)]];
        Ph += h.value[static_cast<std::size_t>(q)] * step.P.col(h.at[static_cast<std::size_t>(q)]);
      }
      double variance = -Ph.dot(Lambda * Ph);
      for (int q = 0; q < h.size; ++q) variance += h.value[static_cast<std::size_t>(q)] * Ph[h.at[static_cast<std::size_t>(q)]];
      const auto g = static_cast<std::size_t>(noise_group(r));
      out.residual[g] += residual * residual + variance;
      out.residual_count[g] += 1.0;
    }
    // back through the measurements of this sample: C = I − K h
    for (int i = step.rows; i-- > 0;) {
      const auto at = static_cast<std::size_t>(i);
      const Row h = measurement_row<size>(flight, k, step.row[at]);
      const Vector<size>& K = step.gain[at];
      const double kl = K.dot(lambda);
      const Vector<size> LK = Lambda * K;
      const double kLk = K.dot(LK);
      for (int q = 0; q < h.size; ++q) {
        const auto a = h.at[static_cast<std::size_t>(q)];
        const double v = h.value[static_cast<std::size_t>(q)];
        lambda[a] -= v * (kl + step.innovation[at] / step.variance[at]);
        Lambda.row(a) -= v * LK.transpose();
        Lambda.col(a) -= v * LK;
      }
      for (int q = 0; q < h.size; ++q)
        for (int s = 0; s < h.size; ++s)
          Lambda(h.at[static_cast<std::size_t>(q)], h.at[static_cast<std::size_t>(s)]) +=
              h.value[static_cast<std::size_t>(q)] * h.value[static_cast<std::size_t>(s)] * (kLk + 1.0 / step.variance[at]);
    }
  }
  return out;
}

}  // namespace

Whitened whiten(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise, const std::vector<Pushes>* extra) {
  if (flight.forces_alone) return whiten_forces(data, flight, noise, extra);
  return noise.errors_last() ? whiten_with<state_size + row_count>(data, flight, noise, extra) : whiten_with<state_size>(data, flight, noise, extra);
}

Smoothed smooth(const LinearFlight& flight, const NoiseModel& noise) {
  if (flight.forces_alone) return smooth_forces(flight);
  return noise.errors_last() ? smooth_with<state_size + row_count>(flight, noise) : smooth_with<state_size>(flight, noise);
}

}  // namespace gustlab::diagnosis
