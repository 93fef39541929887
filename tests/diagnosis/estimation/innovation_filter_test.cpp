#include "diagnosis/estimation/innovation_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "support/linear_flights.hpp"

namespace gustlab::diagnosis {
namespace innovation_filter_test {

constexpr std::size_t samples = 4;
constexpr Eigen::Index states = 18 * static_cast<Eigen::Index>(samples);

using test::some_noise;

// some samples in which every state drives others, positions in every second one
LinearFlight some_flight() {
  LinearFlight flight;
  for (std::size_t k = 0; k < samples; ++k) {
    const double dt = 0.01 + 0.001 * static_cast<double>(k);
    flight.F.push_back(test::some_transition(dt));
    flight.b.push_back(1e-3 * Vector12::LinSpaced(-1.0, 2.0));
    flight.interval_s.push_back(dt);
    flight.starts.push_back(k == 0);
    Eigen::Matrix<bool, row_count, 1> measured = Eigen::Matrix<bool, row_count, 1>::Constant(true);
    measured.head<3>().setConstant(k % 2 == 0);
    flight.measured.push_back(measured);
    flight.y.push_back(1e-2 * Vector12::LinSpaced(1.0, -1.0 - static_cast<double>(k)));
    flight.R_WB.push_back(Eigen::AngleAxisd(0.3, Vector3(1.0, 2.0, -1.0).normalized()).toRotationMatrix());
    flight.force_rows.push_back(Eigen::Matrix<double, 3, 9>::Constant(0.2));
  }
  return flight;
}

// the same as one Gaussian: states of all samples, and what was measured of them
struct Joint {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(states), y;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(states, states), H;
  Eigen::VectorXd R;
  std::vector<std::size_t> group;
};

Joint joint(const LinearFlight& flight, const NoiseModel& noise) {
  Joint all;
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(18, 18);  // matrices of any size: to make templates of a size takes long
  constexpr std::array<double, 4> prior = {4e-6, 4e-3, 4e-4, 4e-2};
  for (int i = 0; i < 12; ++i) P(i, i) = prior[static_cast<std::size_t>(i / 3)];
  for (int j = 0; j < 6; ++j)
    P(12 + j, 12 + j) = noise.variance[static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)])];
  for (std::size_t k = 0; k < samples; ++k) {
    const auto at = 18 * static_cast<Eigen::Index>(k);
    all.covariance.block(at, at, 18, 18) = P;
    for (int r = 0; r < row_count; ++r) {
      if (!flight.measured[k][r]) continue;
      Eigen::RowVectorXd h = Eigen::RowVectorXd::Zero(states);
      if (r < 9) h[at + (r < 3 ? r : 3 + r)] = 1.0;
      else
        h.segment<9>(at + 3) = flight.force_rows[k].row(r - 9),
                          h.segment<3>(at + 12) = flight.R_WB[k].col(r - 9).transpose();
      all.H.conservativeResize(all.H.rows() + 1, states);
      all.H.bottomRows<1>() = h;
      all.R.conservativeResize(all.H.rows()), all.y.conservativeResize(all.H.rows());
      all.R[all.R.size() - 1] = noise.measurement[static_cast<std::size_t>(r / 3)];
      all.y[all.y.size() - 1] = flight.y[k][r];
      all.group.push_back(static_cast<std::size_t>(r / 3));
    }
    if (k + 1 == samples) break;
    const double dt = flight.interval_s[k];
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(18, 18), Q = 1e-14 * Eigen::MatrixXd::Identity(18, 18);
    A.topLeftCorner(12, 12) = flight.F[k];
    for (int j = 0; j < 6; ++j) {
      const auto g = static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)]);
      const int moved = j < 3 ? j : 3 + j;
      A(moved, 12 + j) = 0.5 * dt * dt, A(moved + 3, 12 + j) = dt;
      A(12 + j, 12 + j) = std::exp(-dt / noise.time_s[g]);
      Q(12 + j, 12 + j) += noise.variance[g] * (1.0 - A(12 + j, 12 + j) * A(12 + j, 12 + j));
      Q(moved + 3, moved + 3) += noise.white[g] * dt;
    }
    all.mean.segment(at + 18, 18) = A * all.mean.segment(at, 18);
    all.mean.segment(at + 18, 12) += flight.b[k];
    all.covariance.block(at + 18, 0, 18, at + 18) = A * all.covariance.block(at, 0, 18, at + 18);
    all.covariance.block(0, at + 18, at + 18, 18) = all.covariance.block(at + 18, 0, 18, at + 18).transpose();
    P = A * P * A.transpose() + Q;
  }
  return all;
}

TEST(InnovationFilter, LikelihoodIsThatOfTheJointGaussian) {
  const Joint all = joint(some_flight(), some_noise());
  const Eigen::MatrixXd S = all.H * all.covariance * all.H.transpose() + Eigen::MatrixXd(all.R.asDiagonal());
  const Eigen::VectorXd missed = all.y - all.H * all.mean;
  const Eigen::LLT<Eigen::MatrixXd> factor(S);
  const double expected =
      2.0 * Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum() + missed.dot(factor.solve(missed));
  EXPECT_NEAR(misfit(some_flight(), some_noise()), expected, 1e-7 * std::abs(expected));
  FlightData times;
  times.samples.resize(samples);
  EXPECT_EQ(whiten(times, some_flight(), some_noise()).minus_two_log_likelihood, misfit(some_flight(), some_noise()));
}

// A drag at the hubs turns the body as well. Where torques are not known the attitudes knew better, and a drag that was twice the
// vehicle file's gained nothing.
TEST(InnovationFilter, OfTorquesThatAreNotKnownNothingTurns) {
  LinearFlight flight = some_flight();
  flight.columns = {0, 1};
  SpatialAccelerations pushes = SpatialAccelerations::Zero(6, 2);
  pushes.topRows<3>().setConstant(0.3);
  pushes.col(1).tail<3>().setConstant(2.0);
  flight.acceleration_by.assign(samples, pushes);
  flight.felt_by.assign(samples, Eigen::Matrix<double, 3, 2>::Constant(0.1));
  FlightData times;
  times.samples.resize(samples);
  for (const bool known : {true, false}) {
    flight.torque_known = known;
    const Whitened w = whiten(times, flight, some_noise());
    EXPECT_EQ(w.rows.col(0) == w.rows.col(1), !known);
    const Whitened beside =
        whiten(times, flight, some_noise(), {2, [&](std::size_t) -> const SpatialAccelerations& { return pushes; }});
    EXPECT_EQ(beside.rows.col(2) == beside.rows.col(3), !known);
  }
}

// the states, given what was measured
struct Conditioned {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

Conditioned conditioned(const Joint& all) {
  const Eigen::MatrixXd S = all.H * all.covariance * all.H.transpose() + Eigen::MatrixXd(all.R.asDiagonal());
  const Eigen::MatrixXd gain = S.ldlt().solve(all.H * all.covariance).transpose();
  return {all.mean + gain * (all.y - all.H * all.mean), all.covariance - gain * all.H * all.covariance};
}

TEST(InnovationFilter, MomentsOfTheSmootherAreThoseOfTheConditionedGaussian) {
  const Joint all = joint(some_flight(), some_noise());
  const auto [mean, covariance] = conditioned(all);
  const Eigen::VectorXd left = all.y - all.H * mean;
  const Eigen::MatrixXd spread = all.H * covariance * all.H.transpose();
  const Smoothed smoothed = smooth(some_flight(), some_noise());
  for (Eigen::Index j = 0; j < 6; ++j) {
    double second = 0.0, earlier = 0.0, later = 0.0, lagged = 0.0;
    for (Eigen::Index at = 12 + j; at < states; at += 18) {
      const double square = mean[at] * mean[at] + covariance(at, at);
      second += square;
      if (at + 18 < states) earlier += square;
      if (at >= 18) later += square;
      if (at >= 18) lagged += mean[at] * mean[at - 18] + covariance(at, at - 18);
    }
    EXPECT_NEAR(smoothed.second[static_cast<std::size_t>(j)], second, 1e-7 * second);
    EXPECT_NEAR(smoothed.earlier[static_cast<std::size_t>(j)], earlier, 1e-7 * earlier);
    EXPECT_NEAR(smoothed.later[static_cast<std::size_t>(j)], later, 1e-7 * later);
    EXPECT_NEAR(smoothed.lagged[static_cast<std::size_t>(j)], lagged, 1e-7 * std::abs(lagged));
  }
  std::array<double, noise_groups> residual{};
  for (Eigen::Index i = 0; i < left.size(); ++i)
    residual[all.group[static_cast<std::size_t>(i)]] += left[i] * left[i] + spread(i, i);
  for (std::size_t g = 0; g < noise_groups; ++g) EXPECT_NEAR(smoothed.residual[g], residual[g], 1e-6 * residual[g]);
}

// E[w²] / Δt of the white part: what moves a velocity from one sample to the next beyond the model and the slow disturbance
double white_of(const LinearFlight& flight, const NoiseModel& noise, int j) {
  const auto [mean, covariance] = conditioned(joint(flight, noise));
  const int velocity = j < 3 ? 3 + j : 6 + j;
  double sum = 0.0;
  for (std::size_t k = 0; k + 1 < samples; ++k) {
    const auto at = 18 * static_cast<Eigen::Index>(k);
    Eigen::RowVectorXd w = Eigen::RowVectorXd::Zero(states);
    w[at + 18 + velocity] = 1.0;
    w.segment<12>(at) -= flight.F[k].row(velocity);
    w[at + 12 + j] -= flight.interval_s[k];
    const double mean_w = w.dot(mean) - flight.b[k][velocity];
    sum += (mean_w * mean_w + w * covariance * w.transpose()) / flight.interval_s[k];
  }
  return sum;
}

TEST(EmStep, IsThatOfTheConditionedGaussian) {
  const LinearFlight flight = some_flight();
  const NoiseModel noise = some_noise();
  const Smoothed smoothed = smooth(flight, noise);
  constexpr double sample_s = 0.012;
  const NoiseModel next = update(noise, {smoothed}, sample_s);
  const Joint all = joint(flight, noise);
  const auto [mean, covariance] = conditioned(all);
  for (int g = 0; g < disturbance_groups; ++g) {
    double first = 0.0, earlier = 0.0, later = 0.0, lagged = 0.0, white = 0.0, axes = 0.0;
    for (int j = 0; j < 6; ++j) {
      if (disturbance_group[static_cast<std::size_t>(j)] != g) continue;
      axes += 1.0;
      white += white_of(flight, noise, j);
      const auto square = [&](Eigen::Index at) { return mean[at] * mean[at] + covariance(at, at); };
      first += square(12 + j);
      for (Eigen::Index at = 30 + j; at < states; at += 18) {
        earlier += square(at - 18), later += square(at);
        lagged += mean[at] * mean[at - 18] + covariance(at, at - 18);
      }
    }
    const double pairs = axes * (samples - 1), count = axes * samples;
    const auto at = static_cast<std::size_t>(g);
    EXPECT_NEAR(next.white[at], white / pairs, 1e-5 * white / pairs);
    // −2 log likelihood of the slow part, expected
    const auto squares = [&](double a) { return first + (later - 2.0 * a * lagged + a * a * earlier) / (1.0 - a * a); };
    const auto unlikely = [&](double variance, double time_s) {
      const double a = std::exp(-sample_s / time_s);
      return count * std::log(variance) + pairs * std::log(1.0 - a * a) + squares(a) / variance;
    };
    const double variance = next.variance[at], time_s = next.time_s[at], least = unlikely(variance, time_s);
    const double likeliest = squares(std::exp(-sample_s / time_s)) / count;
    EXPECT_NEAR(variance, likeliest, 1e-6 * likeliest);
    for (const double factor : {0.9, 0.99, 0.999, 1.001, 1.01, 1.1})
      if (const double other_s = std::clamp(factor * time_s, 0.04, slowest_disturbance_s); other_s != time_s) {
        EXPECT_LT(least, unlikely(squares(std::exp(-sample_s / other_s)) / count, other_s));
      }
  }
  const Eigen::VectorXd left = all.y - all.H * mean;
  const Eigen::MatrixXd spread = all.H * covariance * all.H.transpose();
  for (std::size_t g = 0; g < noise_groups; ++g) {
    double sum = 0.0, count = 0.0;
    for (Eigen::Index i = 0; i < left.size(); ++i)
      if (all.group[static_cast<std::size_t>(i)] == g) sum += left[i] * left[i] + spread(i, i), count += 1.0;
    EXPECT_NEAR(next.measurement[g], sum / count, 1e-6 * sum / count);
  }
}

// of the sensors alone the step is exact, so the likelihood cannot fall
TEST(EmStep, OfTheSensorsRaisesTheLikelihood) {
  const LinearFlight flight = some_flight();
  NoiseModel noise = some_noise();
  double before = misfit(flight, noise);
  for (int step = 0; step < 5; ++step) {
    noise.measurement = update(noise, {smooth(flight, noise)}, 0.012).measurement;
    const double after = misfit(flight, noise);
    EXPECT_LT(after, before);
    before = after;
  }
}

}  // namespace innovation_filter_test
}  // namespace gustlab::diagnosis
