// Measured rotor speeds against their commands: whitened rows against a dense Gaussian solve, and a latency that was planted.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "diagnosis/estimation/rotor_speeds.hpp"
#include "diagnosis/estimation/session.hpp"
#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace whitened_speeds_test {

const VehicleModel vehicle = test::crazyflie();
const double hover_radps = vehicle.hover_speed_radps();
constexpr double sample_s = 0.02;

// uneven in time and between rotors, so that nothing is symmetric
RotorArray commanded(double t) {
  RotorArray speeds{};
  for (std::size_t i = 0; i < 4; ++i)
    speeds[i] = hover_radps * (1.0 + 0.25 * std::sin((2.0 + static_cast<double>(i)) * t + static_cast<double>(i)));
  return speeds;
}

struct Speeds {
  FlightData data;
  LinearFlight linear;
};
Speeds some_speeds(double duration_s, double gap_at_s) {
  Speeds s{test::flight_of(
               vehicle, duration_s, sample_s, [](double) { return Motion{}; }, commanded),
           {}};
  s.linear.columns = {0, 1};
  s.linear.predicted_by.resize(2);  // the second column changes no speed
  for (std::size_t k = 0; k < s.data.samples.size(); ++k) {
    const double t = s.data.samples[k].time_s;
    s.data.samples[k].starts_segment = k == 0 || (gap_at_s > 0.0 && std::abs(t - gap_at_s) < 0.5 * sample_s);
    RotorArray faster{}, by{};
    for (std::size_t i = 0; i < 4; ++i)
      faster[i] = 9.0 * std::sin(17.0 * t + static_cast<double>(i)) +
                  5.0 * std::cos(61.0 * t * (1.0 + 0.1 * static_cast<double>(i))),
      by[i] = 20.0 * std::cos(5.0 * t - static_cast<double>(i));
    s.linear.predicted.push_back(commanded(t));
    s.linear.faster.push_back(faster);
    s.linear.predicted_by[0].push_back(by);
  }
  return s;
}

// Covariance of one rotor's samples: σ² exp(−|t − t′| / τ) within a piece, and white noise.
Eigen::MatrixXd covariance(const FlightData& data, const SpeedNoise& noise) {
  const auto n = static_cast<Eigen::Index>(data.samples.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(n, n);
  std::vector<int> piece;
  for (const Sample& s : data.samples) piece.push_back((piece.empty() ? 0 : piece.back()) + (s.starts_segment ? 1 : 0));
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b) {
      const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
      if (piece[i] == piece[j])
        C(a, b) = noise.variance * std::exp(-std::abs(data.samples[i].time_s - data.samples[j].time_s) / noise.time_s);
    }
  C.diagonal().array() += noise.white;
  return C;
}

// Whitening by the inverse of the Cholesky factor is what a filter does; then the map's three columns are projected out.
TEST(WhitenedSpeeds, AreThoseOfADenseGaussianSolve) {
  const SpeedNoise noise{50.0, 0.08, 12.0};
  const Speeds s = some_speeds(1.6, 0.8);
  const Whitened w = whiten_speeds(s.data, s.linear, noise);
  const auto n = static_cast<Eigen::Index>(s.data.samples.size());
  ASSERT_EQ(w.rows.rows(), 4 * n);
  ASSERT_EQ(w.rows.cols(), 3);
  const Eigen::MatrixXd L = covariance(s.data, noise).llt().matrixL();
  double misfit = 0.0;
  for (std::size_t rotor = 0; rotor < 4; ++rotor) {
    Eigen::MatrixXd raw(n, 6);  // column, column of nothing, y, map
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const double speed = s.linear.predicted[at][rotor] / hover_radps;
      raw.row(k) << s.linear.predicted_by[0][at][rotor], 0.0, s.linear.faster[at][rotor], 1.0, speed, speed * speed;
    }
    const Eigen::MatrixXd white = L.triangularView<Eigen::Lower>().solve(raw);
    std::vector<Eigen::Index> warm;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double since_s = s.data.samples[static_cast<std::size_t>(k)].time_s - (k >= 40 ? 0.8 : 0.0);
      EXPECT_EQ(w.warm[static_cast<std::size_t>(4 * k) + rotor], since_s > 0.3) << k;
      if (w.warm[static_cast<std::size_t>(4 * k) + rotor]) warm.push_back(k), misfit += 2.0 * std::log(L(k, k));
    }
    const Eigen::MatrixXd X = white(warm, Eigen::seqN(0, 3)), M = white(warm, Eigen::seqN(3, 3));
    const Eigen::MatrixXd left = X - M * M.colPivHouseholderQr().solve(X);
    for (std::size_t r = 0; r < warm.size(); ++r)
      for (Eigen::Index c = 0; c < 3; ++c)
        EXPECT_NEAR(w.rows(4 * warm[r] + static_cast<Eigen::Index>(rotor), c), left(static_cast<Eigen::Index>(r), c),
                    1e-6);
    misfit += left.col(2).squaredNorm();
  }
  EXPECT_NEAR(w.minus_two_log_likelihood, misfit, 1e-6 * std::abs(misfit));
}

TEST(WhitenedSpeeds, AreNoneWhereTheNoiseIsNotKnown) {
  const Speeds s = some_speeds(1.0, 0.0);
  EXPECT_EQ(whiten_speeds(s.data, s.linear, {50.0, 0.1, 0.0}).rows.rows(), 0);
  EXPECT_EQ(whiten_speeds(s.data, LinearFlight{}, {50.0, 0.1, 1.0}).rows.rows(), 0);
}

// white noise of deviation s: differences of neighbours have the variance 2 s²
TEST(WhitenedSpeeds, FirstGuessIsHalfTheSquareOfTheChanges) {
  Speeds s = some_speeds(1.0, 0.0);
  for (std::size_t k = 0; k < s.linear.faster.size(); ++k) s.linear.faster[k].fill(k % 2 == 0 ? 3.0 : -3.0);
  EXPECT_NEAR(white_speed_noise({s.data}, {s.linear}).white, 0.5 * 36.0, 1e-9);
  EXPECT_EQ(white_speed_noise({s.data}, {LinearFlight{}}).white, 0.0);
}

// a process of this variance and memory beside white noise, drawn: what is found is the truth to a step of the search, and no neighbour is likelier
TEST(WhitenedSpeeds, LikeliestNoiseIsThatWhichWasDrawn) {
  const SpeedNoise truth{60.0, 0.12, 15.0};
  Speeds s = some_speeds(20.0, 0.0);
  s.linear.columns.clear(), s.linear.predicted_by.clear();
  const RandomStream random(3, 0, "whitened_speeds_test");
  const double kept = std::exp(-sample_s / truth.time_s);
  RotorArray slow{};
  for (std::size_t k = 0; k < s.linear.faster.size(); ++k) {
    const auto drawn = random.normal4(k, 0), white = random.normal4(k, 1);
    for (std::size_t i = 0; i < 4; ++i) {
      slow[i] = k == 0 ? std::sqrt(truth.variance) * drawn[i]
                       : kept * slow[i] + std::sqrt((1.0 - kept * kept) * truth.variance) * drawn[i];
      s.linear.faster[k][i] = slow[i] + std::sqrt(truth.white) * white[i];
    }
  }
  const auto misfit = [&](const SpeedNoise& noise) {
    return whiten_speeds(s.data, s.linear, noise).minus_two_log_likelihood;
  };
  const SpeedNoise found = likeliest({s.data}, {s.linear}, white_speed_noise({s.data}, {s.linear}));
  // some 700 independent values of the process: its deviation is known to 3 %, and steps are of 30 %
  EXPECT_NEAR(found.variance / truth.variance, 1.0, 0.35);
  EXPECT_NEAR(found.time_s / truth.time_s, 1.0, 0.35);
  EXPECT_NEAR(found.white / truth.white, 1.0, 0.35);
  for (double SpeedNoise::*part : {&SpeedNoise::variance, &SpeedNoise::time_s, &SpeedNoise::white})
    for (const double by : {1.0 / 1.3, 1.3}) {
      SpeedNoise beside = found;
      beside.*part *= by;
      EXPECT_GE(misfit(beside), misfit(found) - 1.0);
    }
}

// speeds that follow the prediction later, by a whole number of quarters of a sample
TEST(WhitenedSpeeds, LatencyThatWasPlantedIsFound) {
  for (const double quarters : {0.0, 2.0, 6.0, 9.0}) {
    Speeds s = some_speeds(4.0, 0.0);
    const double late_s = 0.25 * quarters * sample_s;
    for (std::size_t k = 0; k < s.linear.faster.size(); ++k) {
      const double t = s.data.samples[k].time_s;
      for (std::size_t i = 0; i < 4; ++i) s.linear.faster[k][i] = commanded(t - late_s)[i] - commanded(t)[i];
    }
    EXPECT_NEAR(speed_latency_s({s.data}, {s.linear}), late_s, 1e-9) << quarters;
  }
}

// The search's first lag and delay, s, where speeds follow commands that jitter from sample to sample so much later.
struct Latencies {
  double lag_s, delay_s;
};
Latencies start_of(const Latencies& flown) {
  const RandomStream random(3, 0, "start_latency");
  FlightData flight = test::flight_of(
      vehicle, 6.0, 0.01, [](double) { return Motion{}; },
      [&](double t) {
        RotorArray speeds = commanded(t);
        const auto jitter = random.normal4(static_cast<std::uint64_t>(std::lround(t / 0.01)), 0);
        for (std::size_t i = 0; i < 4; ++i) speeds[i] += 0.02 * hover_radps * jitter[i];
        return speeds;
      });
  const double gain = flown.lag_s > 0.0 ? 1.0 - std::exp(-0.01 / flown.lag_s) : 1.0;
  RotorArray speed = flight.commands.speed_radps().front();
  const auto followed = [&](double t) {
    const RotorArray command = flight.commands.mean(t - 0.01 - flown.delay_s, t - flown.delay_s);
    for (std::size_t i = 0; i < 4; ++i) speed[i] += gain * (command[i] - speed[i]);
    return speed;
  };
  flight.measured_speed = test::record_of(followed, 6.0, 0.01, true);
  Session session({flight}, vehicle, 1);
  session.linearise(session.value(), session.all_columns());
  Eigen::VectorXd value = session.value();
  session.start_latency(value);
  const auto later_s = [&](Latency kind) {
    const int group = session.catalogue().find(Place::actuation, kind);
    const int c = session.catalogue().group(group).columns.front();
    return value[c] - session.catalogue().nominal()[c];
  };
  return {later_s(Latency::lag), later_s(Latency::delay)};
}

TEST(StartLatency, IsNearALagADelayOrNoneThatWasPlanted) {
  const Latencies lag = start_of({0.06, 0.0}), delay = start_of({0.0, 0.03}), none = start_of({0.0, 0.0});
  EXPECT_NEAR(lag.lag_s, 0.06, 0.025);
  EXPECT_EQ(lag.delay_s, 0.0);
  EXPECT_EQ(delay.lag_s, 0.0);
  EXPECT_NEAR(delay.delay_s, 0.03, 0.011);
  EXPECT_EQ(none.lag_s, 0.0);
  EXPECT_EQ(none.delay_s, 0.0);
}

}  // namespace whitened_speeds_test
}  // namespace gustlab::diagnosis
