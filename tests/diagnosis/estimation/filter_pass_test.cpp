// Each step of the filter's pass against dense matrices: what a sample tells, and what comes of it until the next.
#include "diagnosis/estimation/filter_pass.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "diagnosis/model/propagation.hpp"
#include "support/linear_flights.hpp"

namespace gustlab::diagnosis {
namespace filter_pass_test {

NoiseModel some_noise() {
  NoiseModel noise = test::some_noise();
  noise.lasting_variance = {2e-6, 3e-5, 2e-4, 0.02};
  noise.lasting_time_s = {0.1, 0.2, 0.05, 0.15};
  return noise;
}

LinearFlight some_flight() {
  LinearFlight flight;
  flight.center_of_mass_B_m = {0.02, -0.01, 0.03};
  for (int k = 0; k < 3; ++k) {
    const double dt = 0.01 + 0.002 * k;
    flight.F.push_back(test::some_transition(dt));
    flight.b.push_back(1e-3 * Vector12::LinSpaced(-1.0, 2.0));
    flight.interval_s.push_back(dt);
    flight.starts.push_back(k == 0);
    Eigen::Matrix<bool, row_count, 1> measured = Eigen::Matrix<bool, row_count, 1>::Constant(true);
    measured.segment<3>(3).setConstant(k != 1);
    flight.measured.push_back(measured);
    flight.y.push_back(1e-2 * Vector12::LinSpaced(1.0, -1.0 - k));
    flight.R_WB.push_back(Eigen::AngleAxisd(0.3 + k, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix());
    flight.force_rows.push_back(Eigen::Matrix<double, 3, 9>::Constant(0.2 + 0.1 * k));
  }
  return flight;
}

Matrix3 skew(const Vector3& v) {
  Matrix3 S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

// what every row would measure of the state
Eigen::MatrixXd all_rows(int size, const LinearFlight& flight, std::size_t k) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(row_count, size);
  H.block(0, 0, 3, 3).setIdentity();
  H.block(0, 6, 3, 3) = flight.R_WB[k] * skew(flight.center_of_mass_B_m);
  H.block(3, 6, 6, 6).setIdentity();
  H.block(9, 3, 3, 9) = flight.force_rows[k];
  H.block(9, 12, 3, 3) = flight.R_WB[k].transpose();
  if (size > state_size) H.rightCols(row_count).setIdentity();
  return H;
}

// One Gaussian, and a column of a regression that the pass carries beside it. Matrices of any size: to make templates of a size takes long.
struct Dense {
  Eigen::MatrixXd P;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(P.rows()), column = mean;
};

constexpr double column_at_row = 0.01, column_of_motion = 1e-3;

template <int size>
void expect_same(FilterPass<size>& pass, const Dense& dense, const char* when) {
  EXPECT_LT((pass.state().leftCols(size) - dense.P).cwiseAbs().maxCoeff(), 1e-11) << when;
  EXPECT_LT((pass.state().col(size) + dense.mean).cwiseAbs().maxCoeff(), 1e-11) << when;
  EXPECT_LT((pass.state().col(size + 1) + dense.column).cwiseAbs().maxCoeff(), 1e-11) << when;
}

// the sample is one vector; whitening row by row is the inverse of its Cholesky factor
template <int size>
void measure_both(FilterPass<size>& pass, Dense& dense, const LinearFlight& flight, const NoiseModel& noise,
                  std::size_t k) {
  pass.measure(k, [&](int row, double* e) { e[FilterPass<size>::first_column] += column_at_row * (row + 1); });
  Eigen::MatrixXd H;
  Eigen::VectorXd y, D, R;
  for (int r = 0; r < row_count; ++r) {
    if (!flight.measured[k][r]) continue;
    const Eigen::Index n = H.rows() + 1;
    H.conservativeResize(n, size), y.conservativeResize(n), D.conservativeResize(n), R.conservativeResize(n);
    H.bottomRows<1>() = all_rows(size, flight, k).row(r);
    y[n - 1] = flight.y[k][r], D[n - 1] = column_at_row * (r + 1);
    R[n - 1] = noise.measurement[static_cast<std::size_t>(r / 3)];
    EXPECT_EQ(pass.row(n - 1), r);
  }
  ASSERT_EQ(pass.rows(), H.rows());
  const Eigen::MatrixXd S = H * dense.P * H.transpose() + Eigen::MatrixXd(R.asDiagonal());
  const Eigen::MatrixXd L = S.llt().matrixL(), K = S.ldlt().solve(H * dense.P).transpose();
  const Eigen::VectorXd z = L.triangularView<Eigen::Lower>().solve(y - H * dense.mean);
  const Eigen::VectorXd of_column = L.triangularView<Eigen::Lower>().solve(D - H * dense.column);
  const Eigen::Index n = H.rows();
  EXPECT_LT((pass.innovations().col(size).head(n) - z).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((pass.innovations().col(size + 1).head(n) - of_column).cwiseAbs().maxCoeff(), 1e-8);
  for (Eigen::Index i = 0; i < n; ++i) EXPECT_NEAR(pass.variance(i), L(i, i) * L(i, i), 1e-9 * L(i, i) * L(i, i));
  dense.mean += K * (y - H * dense.mean);
  dense.column += K * (D - H * dense.column);
  dense.P -= (K * H * dense.P).eval();
}

template <int size>
void advance_both(FilterPass<size>& pass, Dense& dense, const LinearFlight& flight, const NoiseModel& noise,
                  std::size_t k) {
  const double dt = flight.interval_s[k];
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size), Q = 1e-14 * Eigen::MatrixXd::Identity(size, size);
  A.topLeftCorner(12, 12) = flight.F[k];
  const auto remembers = [&](int at, double variance, double time_s) {
    A(at, at) = std::exp(-dt / time_s);
    Q(at, at) += variance * (1.0 - A(at, at) * A(at, at));
  };
  for (int j = 0; j < 6; ++j) {
    const auto g = static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)]);
    const int moved = j < 3 ? j : 3 + j;
    A(moved, 12 + j) = 0.5 * dt * dt, A(moved + 3, 12 + j) = dt;
    remembers(12 + j, noise.variance[g], noise.time_s[g]);
    Q(moved + 3, moved + 3) += noise.white[g] * dt;
  }
  for (int j = state_size; j < size; ++j) {
    const auto g = static_cast<std::size_t>((j - state_size) / 3);
    remembers(j, noise.lasting_variance[g], noise.lasting_time_s[g]);
  }
  if (!flight.torque_known) Q.diagonal().segment(9, 3).array() += 1e4 * dt;
  pass.advance(k);
  // what a push changes is the caller's to add
  for (int i = 0; i < 12; ++i) pass.state()(i, size + 1) -= column_of_motion * (i + 1);
  dense.P = (A * dense.P * A.transpose() + Q).eval();
  dense.mean = (A * dense.mean).eval();
  dense.mean.head(12) += flight.b[k];
  dense.column = (A * dense.column).eval();
  dense.column.head(12) += column_of_motion * Vector12::LinSpaced(1.0, 12.0);
}

template <int size>
void expect_a_kalman_filter(const LinearFlight& flight) {
  const NoiseModel noise = some_noise();
  FilterPass<size> pass(flight, noise, 1);
  pass.start(0);
  Dense dense{pass.state().leftCols(size)};
  expect_same(pass, dense, "start");
  for (std::size_t k = 0; k < 3; ++k) {
    measure_both(pass, dense, flight, noise, k);
    // a covariance loses ten digits against a variance of a million
    if (flight.torque_known) expect_same(pass, dense, "measured");
    if (k == 2) break;
    advance_both(pass, dense, flight, noise, k);
    if (flight.torque_known) expect_same(pass, dense, "advanced");
  }
}

TEST(FilterPass, IsAKalmanFilter) { expect_a_kalman_filter<state_size>(some_flight()); }

TEST(FilterPass, IsOneWhereErrorsLast) { expect_a_kalman_filter<state_size + row_count>(some_flight()); }

TEST(FilterPass, FreesTheRotationWhereNoTorqueIsKnown) {
  LinearFlight flight = some_flight();
  flight.torque_known = false;
  const NoiseModel noise = some_noise();
  FilterPass<state_size> pass(flight, noise, 0);
  pass.set_transition(0);
  for (int i = 9; i < 12; ++i) EXPECT_EQ(pass.process(i), 1e4 * flight.interval_s[0]);
  EXPECT_LT(pass.process(3), 1e-4);
}

TEST(FilterPass, StartsWideWhereNothingIsMeasured) {
  LinearFlight flight = some_flight();
  const NoiseModel noise = some_noise();
  FilterPass<state_size> seen(flight, noise, 0);
  seen.start(0);
  flight.measured[0].head<6>().setConstant(false);
  FilterPass<state_size> blind(flight, noise, 0);
  blind.start(0);
  for (int i = 0; i < 9; ++i) EXPECT_GT(blind.state()(i, i), 10.0 * seen.state()(i, i)) << i;
  for (int i = 9; i < state_size; ++i) EXPECT_EQ(blind.state()(i, i), seen.state()(i, i)) << i;
}

// the logged origin is a lever away from the centre of mass whose error the state is
TEST(FilterPass, PositionRowIsTheDerivativeOfTheOrigin) {
  const LinearFlight flight = some_flight();
  const Vector3& arm = flight.center_of_mass_B_m;
  Point point;
  point.position = {1.0, 2.0, 3.0};
  point.attitude = Quaternion(flight.R_WB[1]);
  const auto origin = [&](const Point& at) { return Vector3(at.position - at.attitude * arm); };
  constexpr double step = 1e-6;
  for (int row = 0; row < 3; ++row) {
    Eigen::VectorXd dense = Eigen::VectorXd::Zero(state_size);
    const SparseRow h = FilterPass<state_size>::measurement_row(flight, 1, row);
    for (std::size_t i = 0; i < static_cast<std::size_t>(h.size); ++i) dense[h.at[i]] += h.value[i];
    for (int i = 0; i < error_size; ++i) {
      Point plus = point.plus(i, step), minus = point.plus(i, -step);
      EXPECT_NEAR(dense[i], (origin(plus) - origin(minus))[row] / (2.0 * step), 1e-8) << row << ' ' << i;
    }
  }
}

}  // namespace filter_pass_test
}  // namespace gustlab::diagnosis
