#include "diagnosis/innovation_filter.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/direct_forces.hpp"

namespace gustlab::diagnosis {

namespace {

using Matrix18 = Eigen::Matrix<double, 18, 18>;
using Vector18 = Eigen::Matrix<double, 18, 1>;
using Columns = Eigen::Matrix<double, 18, Eigen::Dynamic, Eigen::RowMajor>;

// how far the smoothed trajectory may be from the truth at the start of a segment (Crazyflie to Iris)
constexpr std::array<double, 4> prior_variance = {4e-6, 4e-3, 4e-4, 4e-2};

// one row of H: the few entries that are not zero
struct Row {
  std::array<int, 12> at;
  std::array<double, 12> value;
  int size = 0;
  void add(int index, double v) {
    at[static_cast<std::size_t>(size)] = index;
    value[static_cast<std::size_t>(size++)] = v;
  }
};

Row measurement_row(const LinearFlight& flight, std::size_t k, int row) {
  Row h;
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

// what the white acceleration of an axis changes: velocity, body rate
int white_row(int axis) { return axis < 3 ? 3 + axis : 6 + axis; }

// transition of error and disturbance over one interval
struct Transition {
  Matrix18 A;
  Vector18 process;  // variance added
};

void transition(const LinearFlight& flight, std::size_t k, const NoiseModel& noise, Transition& out) {
  const double dt = flight.interval_s[k];
  out.A.setZero();
  out.A.topLeftCorner<12, 12>() = flight.F[k];
  for (int i = 0; i < 3; ++i) {
    out.A(i, 12 + i) = 0.5 * dt * dt;
    out.A(3 + i, 12 + i) = dt;
    out.A(6 + i, 15 + i) = 0.5 * dt * dt;
    out.A(9 + i, 15 + i) = dt;
  }
  out.process.setConstant(1e-14);
  out.process.segment<3>(6).setConstant(1e-14);
  for (int i = 0; i < 6; ++i) {
    const auto g = static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(i)]);
    const double decay = std::exp(-dt / noise.time_s[g]);
    out.A(12 + i, 12 + i) = decay;
    out.process[12 + i] = noise.variance[g] * (1.0 - decay * decay);
    out.process[white_row(i)] += noise.white[g] * dt;
  }
  // torques unknown: the rotation is free, so that only forces tell
  if (!flight.torque_known) out.process.segment<3>(9).setConstant(1e4 * dt);
}

void start(const NoiseModel& noise, Matrix18& P, const LinearFlight& flight, std::size_t k) {
  P.setZero();
  for (int i = 0; i < 12; ++i) P(i, i) = prior_variance[static_cast<std::size_t>(i / 3)];
  // what is never measured is not known to a millimetre
  if (!flight.measured[k][0])
    for (int i = 0; i < 6; ++i) P(i, i) = 1.0;
  if (!flight.measured[k][3])
    for (int i = 6; i < 9; ++i) P(i, i) = 0.25;
  for (int i = 0; i < 6; ++i)
    P(12 + i, 12 + i) = noise.variance[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(i)])];
}

// [F Γ] M, where Γ moves only the error's own axis: two entries a column
template <int columns>
Eigen::Matrix<double, 12, columns> upper_times(const Transition& t, const Eigen::Matrix<double, 18, columns>& M) {
  const Matrix12 F = t.A.topLeftCorner<12, 12>();
  Eigen::Matrix<double, 12, columns> result = F.lazyProduct(M.template topRows<12>());
  for (int i = 0; i < 12; ++i) {
    const int d = 12 + i % 3 + (i < 6 ? 0 : 3);
    result.row(i) += t.A(i, d) * M.row(d);
  }
  return result;
}

// M A of the same A
Matrix18 times(const Matrix18& M, const Transition& t) {
  const Matrix12 F = t.A.topLeftCorner<12, 12>();
  Matrix18 result;
  result.leftCols<12>() = M.leftCols<12>().lazyProduct(F);
  result.rightCols<6>() = M.rightCols<6>() * t.A.diagonal().tail<6>().asDiagonal();
  for (int i = 0; i < 12; ++i) {
    const int d = 12 + i % 3 + (i < 6 ? 0 : 3);
    result.col(d) += t.A(i, d) * M.col(i);
  }
  return result;
}

// P⁺ = A P Aᵀ + process, with A's lower-left block zero and its lower-right diagonal
void propagate(const Transition& t, Matrix18& P) {
  const Eigen::Matrix<double, 12, 18> upper = upper_times<18>(t, P);
  const Eigen::Matrix<double, 6, 1> decay = t.A.diagonal().tail<6>();
  P.bottomRightCorner<6, 6>() = decay.asDiagonal() * P.bottomRightCorner<6, 6>() * decay.asDiagonal();
  P.topRightCorner<12, 6>() = upper.rightCols<6>() * decay.asDiagonal();
  P.bottomLeftCorner<6, 12>() = P.topRightCorner<12, 6>().transpose();
  const Matrix12 corner = upper_times<12>(t, upper.transpose());
  P.topLeftCorner<12, 12>() = 0.5 * (corner + corner.transpose());
  P.diagonal() += t.process;
}

}  // namespace

Whitened whiten(const FlightData& data, const LinearFlight& flight, const NoiseModel& noise,
                const std::vector<Pushes>* extra) {
  if (flight.forces_alone) return whiten_forces(data, flight, noise, extra);
  const std::size_t n = flight.size();
  const auto own = static_cast<Eigen::Index>(flight.columns.size());
  const Eigen::Index more = extra ? (*extra)[0].cols() : 0;
  const Eigen::Index width = own + more + 1;
  Whitened out;
  out.rows.resize(static_cast<Eigen::Index>(n * row_count), width);

  Matrix18 P = Matrix18::Zero();
  Columns X = Columns::Zero(18, width);
  Transition t;
  Eigen::RowVectorXd e(width);
  Eigen::Matrix<double, 3, Eigen::Dynamic> extra_felt;
  Vector18 gain;
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
      const Row h = measurement_row(flight, k, r);
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
      for (int i = 0; i < 18; ++i) X.row(i) -= gain[i] * e;
      P -= gain * (variance * gain.transpose());
    }
    ++since_start;
    if (k + 1 == n || flight.starts[k + 1]) continue;
    transition(flight, k, noise, t);
    Columns next(18, width);
    next.topRows<12>().noalias() = t.A.topRows<12>() * X;
    next.bottomRows<6>() = t.A.diagonal().tail<6>().asDiagonal() * X.bottomRows<6>();
    if (own > 0) next.topLeftCorner(12, own) += flight.B[k];
    if (more > 0) next.block(0, own, 12, more) += moved_by((*extra)[k], flight.interval_s[k]);
    next.col(width - 1).head<12>() += flight.b[k];
    X.swap(next);
    propagate(t, P);
  }
  out.rows.conservativeResize(row_index, Eigen::NoChange);
  return out;
}

Smoothed smooth(const LinearFlight& flight, const NoiseModel& noise) {
  if (flight.forces_alone) return smooth_forces(flight);
  const std::size_t n = flight.size();
  struct Step {
    Vector18 x;                 // after the measurements of this sample
    Matrix18 P;
    Vector18 x_before;
    Matrix18 P_before;          // before them
    int rows = 0;
    std::array<double, row_count> innovation, variance;
    std::array<int, row_count> row;
    std::array<Vector18, row_count> gain;
  };
  std::vector<Step> steps(n);
  Vector18 x = Vector18::Zero();
  Matrix18 P = Matrix18::Zero();
  Transition t;
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
      const Row h = measurement_row(flight, k, r);
      Vector18 gain = Vector18::Zero();
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
    x.head<12>() += flight.b[k];
    propagate(t, P);
  }

  // modified Bryson–Frazier: x_smooth = x − P λ, P_smooth = P − P Λ P; no inverse
  Smoothed out;
  out.disturbance.assign(n, Eigen::Matrix<double, 6, 1>::Zero());
  out.disturbance_variance.resize(n);
  Vector18 lambda = Vector18::Zero();
  Matrix18 Lambda = Matrix18::Zero();
  for (std::size_t k = n; k-- > 0;) {
    const Step& step = steps[k];
    const bool linked = k + 1 < n && !flight.starts[k + 1];
    if (!linked) {
      lambda.setZero();
      Lambda.setZero();
    } else {
      // here λ, Λ are of sample k + 1 before its measurements
      transition(flight, k, noise, t);
      const Vector18 lambda_next = lambda;
      const Matrix18 Lambda_next = Lambda;
      lambda = t.A.transpose() * lambda_next;
      Lambda = times(times(Lambda_next, t).transpose(), t);
      Lambda = (0.5 * (Lambda + Lambda.transpose())).eval();
      for (int j = 0; j < 6; ++j) {
        // Cov(d_{k+1}, d_k | all) = [A P_k]_{jj} − P⁻_{k+1} Λ_{k+1} A P_k
        const Vector18 through = t.A * step.P.col(12 + j);
        const double covariance = through[12 + j] - steps[k + 1].P_before.row(12 + j) * (Lambda_next * through);
        const double mean_next = steps[k + 1].x_before[12 + j] - steps[k + 1].P_before.row(12 + j).dot(lambda_next);
        const double mean = step.x[12 + j] - step.P.row(12 + j).dot(lambda);
        out.lagged[static_cast<std::size_t>(j)] += mean_next * mean + covariance;
        out.pairs[static_cast<std::size_t>(j)] += 1.0;
        // of white acceleration with variance q of what it changes: mean −q λ, second moment q + q² (λ² − Λ)
        const int at = white_row(j);
        const double power = noise.white[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)])], q = power * flight.interval_s[k];
        out.white[static_cast<std::size_t>(j)] += power + power * q * (lambda_next[at] * lambda_next[at] - Lambda_next(at, at));
        out.disturbance[k][j] = -power * lambda_next[at];
      }
    }
    for (int j = 0; j < 6; ++j) {
      const double mean = step.x[12 + j] - step.P.row(12 + j).dot(lambda);
      const double variance = step.P(12 + j, 12 + j) - step.P.row(12 + j) * Lambda * step.P.col(12 + j);
      out.disturbance[k][j] += mean;
      out.disturbance_variance[k][j] = variance;
      out.second[static_cast<std::size_t>(j)] += mean * mean + variance;
      out.count[static_cast<std::size_t>(j)] += 1.0;
    }
    const Vector18 smoothed = step.x - step.P * lambda;
    for (int i = 0; i < step.rows; ++i) {
      const int r = step.row[static_cast<std::size_t>(i)];
      const Row h = measurement_row(flight, k, r);
      double residual = flight.y[k][r];
      Vector18 Ph = Vector18::Zero();
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
      const Row h = measurement_row(flight, k, step.row[at]);
      const Vector18& K = step.gain[at];
      const double kl = K.dot(lambda);
      const Vector18 LK = Lambda * K;
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

double NoiseModel::rms(std::size_t group) const {
  return std::sqrt(variance[group] + white[group] / (2.0 * white_mean_s(group)));
}

NoiseModel update(const NoiseModel& noise, const std::vector<Smoothed>& flights, double sample_s) {
  NoiseModel next = noise;
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    double second = 0.0, count = 0.0, lagged = 0.0, pairs = 0.0, white = 0.0;
    for (const Smoothed& f : flights)
      for (std::size_t j = 0; j < 6; ++j)
        if (disturbance_group[j] == static_cast<int>(g)) {
          second += f.second[j], count += f.count[j], white += f.white[j];
          lagged += f.lagged[j], pairs += f.pairs[j];
        }
    if (count == 0.0) continue;
    next.variance[g] = std::max(second / count, 1e-12);
    next.white[g] = std::max(white / pairs, noise.least_white[g]);
    const double correlation = std::clamp(lagged / pairs / (second / count), 0.02, 0.9995);
    // what is faster is the white part's, where there is one
    next.time_s[g] = std::clamp(-sample_s / std::log(correlation), white > 0.0 ? 0.04 : 0.004, slowest_disturbance_s);
  }
  for (std::size_t g = 0; g < noise_groups; ++g) {
    double sum = 0.0, count = 0.0;
    for (const Smoothed& f : flights) sum += f.residual[g], count += f.residual_count[g];
    if (count > 0.0) next.measurement[g] = std::max(sum / count, 1e-14);
  }
  return next;
}

NoiseModel extrapolated(const NoiseModel& first, const NoiseModel& second, const NoiseModel& third) {
  constexpr double slowest = 0.95, farthest = 1.5;
  // the limit of a geometric series
  const auto limit = [&](double a, double b, double c) {
    const double before = std::log(b / a), last = std::log(c / b);
    const double rate = before * last > 0.0 ? std::min(last / before, slowest) : 0.0;
    return c * std::exp(std::clamp(last * rate / (1.0 - rate), -farthest, farthest));
  };
  NoiseModel result = third;
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    result.variance[g] = limit(first.variance[g], second.variance[g], third.variance[g]);
    result.time_s[g] = std::min(limit(first.time_s[g], second.time_s[g], third.time_s[g]), slowest_disturbance_s);
    result.white[g] = std::max(limit(first.white[g], second.white[g], third.white[g]), third.least_white[g]);
  }
  for (std::size_t g = 0; g < noise_groups; ++g)
    result.measurement[g] = limit(first.measurement[g], second.measurement[g], third.measurement[g]);
  return result;
}

}  // namespace gustlab::diagnosis
