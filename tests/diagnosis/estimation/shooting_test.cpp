// Predictions half a second ahead of a flight that accelerates as nobody expects, and the weights of their windows.
#include "diagnosis/estimation/shooting.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace shooting_test {

constexpr double sample_s = 0.02, extra_mps2 = 0.3;
constexpr int window_rows = 30;

VehicleModel vehicle() {
  VehicleModel model = test::ring(4, 1.5, 0.25, 0.0);
  model.effects.clear();
  return model;
}

Catalogue catalogue() {
  return {vehicle(), 1, {.observable = Need::attitude | Need::motion | Need::torque, .trims = true}};
}

// hover commands, and a climb ever faster
FlightData climb() {
  return test::flight_of(
      vehicle(), 6.0, sample_s,
      [](double t) {
        Motion motion;
        motion.position_W_m.z() = 0.5 * extra_mps2 * t * t;
        motion.velocity_W_mps.z() = extra_mps2 * t;
        motion.acceleration_W_mps2.z() = extra_mps2;
        return motion;
      },
      [](double) { return test::all_at(vehicle().hover_speed_radps()); });
}

int mass_column(const Catalogue& all) { return all.group(all.find("mass")).columns.front(); }

// what is missed grows with the horizon as a t, and what a mass changes as −g t
TEST(Shooting, MissesWhatNobodyExpectsAndKnowsWhatAMassWouldDo) {
  const Catalogue all = catalogue();
  const int mass = mass_column(all);
  const ShotFlight shot = shoot(climb(), 0, all, all.nominal(), {mass}, 0.5);
  ASSERT_GE(shot.window.size(), 5u);
  ASSERT_EQ(shot.columns, std::vector<int>{mass});
  const double natural = all.column(mass).natural;
  for (const Eigen::MatrixXd& window : shot.window) {
    ASSERT_EQ(window.rows(), window_rows);
    for (std::size_t h = 0; h < shooting_horizon_s.size(); ++h)
      for (int i = 0; i < 6; ++i) {
        const auto row = static_cast<Eigen::Index>(h) * 6 + i;
        const double t = shooting_horizon_s[h];
        EXPECT_NEAR(window(row, 1), i == 2 ? extra_mps2 * t : 0.0, 1e-6) << h << ' ' << i;
        EXPECT_NEAR(window(row, 0), i == 2 ? -9.81 * t * natural : 0.0, 2e-3 * 9.81 * t * natural) << h << ' ' << i;
      }
  }
}

// a gyroscope that read nothing would be predicted best of all
TEST(Shooting, SaysNothingOfAGyroscopesScale) {
  const Catalogue all(vehicle(), 1,
                      {.observable = Need::attitude | Need::motion | Need::torque | Need::gyro, .trims = true});
  const int scale = all.group(all.find("gyro_scale")).columns.front();
  FlightData turning = climb();
  for (Sample& sample : turning.samples) sample.body_rate_B_radps = {0.0, 0.0, 1.0};
  for (const Eigen::MatrixXd& window : shoot(turning, 0, all, all.nominal(), {scale}, 0.5).window)
    EXPECT_TRUE(window.col(0).isZero());
}

// turned by torques that a total thrust says nothing of, flights had a quadratic drag for one at the hubs
TEST(Shooting, OfTorquesThatNobodyKnowsItPredictsNoTurn) {
  const Catalogue all = catalogue();
  const int inertia = all.group(all.find("inertia")).columns.front();
  FlightData rolling = climb();
  for (std::size_t k = 0; k < rolling.motion.size(); ++k)
    rolling.motion[k].body_rate_B_radps.x() = 0.5 * sample_s * static_cast<double>(k);
  for (const bool collective : {false, true}) {
    rolling.collective_only = collective;
    double largest = 0.0;
    for (const Eigen::MatrixXd& window : shoot(rolling, 0, all, all.nominal(), {inertia}, 0.5).window)
      for (std::size_t h = 0; h < shooting_horizon_s.size(); ++h)
        largest = std::max(largest, window.middleRows<3>(static_cast<Eigen::Index>(h) * 6 + 3).cwiseAbs().maxCoeff());
    EXPECT_EQ(largest == 0.0, collective) << largest;
  }
}

TEST(Shooting, MissesAtAnotherValueWhatANewShotWouldMiss) {
  const Catalogue all = catalogue();
  const int mass = mass_column(all);
  ShotFlight shot = shoot(climb(), 0, all, all.nominal(), {mass}, 0.5);
  const ShotFlight before = shot;
  Eigen::VectorXd heavier = all.nominal();
  heavier[mass] += 0.05;
  shoot_again(climb(), 0, all, heavier, 0.5, shot);
  const ShotFlight anew = shoot(climb(), 0, all, heavier, {mass}, 0.5);
  for (std::size_t w = 0; w < shot.window.size(); ++w) {
    EXPECT_EQ(shot.window[w].col(1), anew.window[w].col(1));
    EXPECT_NE(shot.window[w].col(1), before.window[w].col(1));
    EXPECT_EQ(shot.window[w].col(0), before.window[w].col(0));
  }
}

// the variational equation against shots at both sides of the nominal vehicle, of every column and sensor
TEST(Shooting, ColumnsAreWhatAShotAtAnotherValueMisses) {
  const Need seen = Need::attitude | Need::motion | Need::torque | Need::gyro;
  const Catalogue all(vehicle(), 1, {.observable = seen, .trims = true, .smoothing = true});
  const double hover_radps = vehicle().hover_speed_radps();
  const Quaternion bank(Eigen::AngleAxisd(0.3, Vector3::UnitX()));
  const FlightData turning = test::flight_of(
      vehicle(), 4.0, sample_s,
      [&](double t) {
        const Vector3 rate_B(0.0, 0.4 * std::sin(0.3), 0.4 * std::cos(0.3));  // 0.4 rad/s about the vertical
        Motion motion;
        motion.attitude_WB = Eigen::AngleAxisd(0.4 * t, Vector3::UnitZ()) * bank;
        motion.velocity_W_mps = Vector3(4.0 * std::cos(0.4 * t), 4.0 * std::sin(0.4 * t), 0.5);
        motion.position_W_m = Vector3(10.0 * std::sin(0.4 * t), 10.0 * (1.0 - std::cos(0.4 * t)), 2.0 + 0.5 * t);
        motion.body_rate_B_radps = rate_B;
        return motion;
      },
      [&](double t) {
        RotorArray speeds = test::all_at(1.02 * hover_radps);
        for (std::size_t i = 0; i < 4; ++i) speeds[i] *= 1.0 + 0.02 * std::sin(4.0 * t + static_cast<double>(i));
        return speeds;
      });
  std::vector<int> columns;
  for (int c = 0; c < all.size(); ++c) columns.push_back(c);
  const ShotFlight shot = shoot(turning, 0, all, all.nominal(), columns, 0.5);
  const ShotFlight by_threads = shoot(turning, 0, all, all.nominal(), columns, 0.5, 3);
  for (std::size_t w = 0; w < shot.window.size(); ++w) EXPECT_EQ(shot.window[w], by_threads.window[w]);
  int compared = 0;
  for (std::size_t j = 0; j < shot.columns.size(); ++j) {
    const Column& column = all.column(shot.columns[j]);
    if (column.group == all.find("gyro_scale")) continue;
    Eigen::VectorXd above = all.nominal(), below = above;
    above[shot.columns[j]] += 1e-3 * column.natural;
    below[shot.columns[j]] = std::max(column.min, below[shot.columns[j]] - 1e-3 * column.natural);
    ShotFlight more = shot, less = shot;
    shoot_again(turning, 0, all, above, 0.5, more);
    shoot_again(turning, 0, all, below, 0.5, less);
    double off = 0.0, size = 0.0;
    for (std::size_t w = 0; w < shot.window.size(); ++w) {
      const Eigen::VectorXd expected =
          (less.window[w].rightCols<1>() - more.window[w].rightCols<1>()) * (column.natural / (above - below).sum());
      off += (shot.window[w].col(static_cast<Eigen::Index>(j)) - expected).squaredNorm();
      size += expected.squaredNorm();
    }
    EXPECT_LE(std::sqrt(off), 0.04 * std::sqrt(size)) << column.group << ' ' << column.parameter;
    compared += size > 0.0;
  }
  EXPECT_GT(compared, 35);
}

TEST(Shooting, WindowsDoNotCrossGapsOrLimits) {
  const Catalogue all = catalogue();
  FlightData torn = climb();
  const std::size_t whole = shoot(torn, 0, all, all.nominal(), {}, 0.1).window.size();
  torn.samples[150].starts_segment = true;
  torn.samples[220].saturated = true;
  const ShotFlight shot = shoot(torn, 0, all, all.nominal(), {}, 0.1);
  EXPECT_LT(shot.window.size(), whole);
  for (const double start_s : shot.time_s)
    for (const double bad_s : {150 * sample_s, 220 * sample_s})
      EXPECT_FALSE(start_s < bad_s - 1e-9 && bad_s <= start_s + 0.5 + 1e-9) << start_s;
}

// an error that grows along the horizons, alike in every window
struct Errors {
  Eigen::MatrixXd spread;
  std::vector<ShotFlight> flights = {ShotFlight{}};

  explicit Errors(int windows) : spread(window_rows, window_rows) {
    const RandomStream random(4, 0, "shooting_test");
    std::uint64_t counter = 0;
    Eigen::MatrixXd root = Eigen::MatrixXd::Zero(window_rows, window_rows);
    for (int i = 0; i < window_rows; ++i)
      for (int j = i % 6; j <= i; j += 6) root(i, j) = 0.1 * (1 + j / 6);
    spread = root * root.transpose();
    for (int w = 0; w < windows; ++w) {
      Eigen::VectorXd z(window_rows);
      for (double& x : z) x = random.normal4(counter++)[0];
      Eigen::MatrixXd window = Eigen::MatrixXd::Zero(window_rows, 2);
      window.col(0).setConstant(0.5);
      // the column at 2 explains what is not chance
      window.col(1) = root * z + 2.0 * window.col(0);
      flights[0].window.push_back(window);
      flights[0].time_s.push_back(0.5 * w);
    }
  }
};

TEST(ShootingWeights, WhitenWhatTheColumnsLeave) {
  const Catalogue all = catalogue();
  Errors errors(4000);
  const int mass = mass_column(all);
  errors.flights[0].columns = {mass};
  const ShootingWeights weights = shooting_weights(errors.flights, {mass}, Eigen::VectorXd::Constant(1, 2.0));
  const Eigen::MatrixXd white = weights * errors.spread * weights.transpose();
  EXPECT_LT((white.diagonal().array() - 1.0).abs().maxCoeff(), 0.25);
  EXPECT_NEAR(white.trace() / window_rows, 1.0, 0.1);
  EXPECT_LT((white - Eigen::MatrixXd(white.diagonal().asDiagonal())).cwiseAbs().maxCoeff(), 0.25);
  EXPECT_TRUE(shooting_weights({}, {}, {}).isIdentity());
}

// a fit of k numbers to n rows leaves n − k of them
TEST(ShootingWeights, CountWhatTheFitTookOfTheNoise) {
  Errors errors(40);
  const ShootingWeights known = shooting_weights(errors.flights, {}, {});
  const std::vector<int> columns(300, -1);  // of none of these flights
  const ShootingWeights fitted = shooting_weights(errors.flights, columns, Eigen::VectorXd::Zero(300));
  const double rows = 40.0 * window_rows;
  EXPECT_LT((known * std::sqrt((rows - 300.0) / rows) - fitted).norm(), 1e-9 * known.norm());
}

double size_of_white(const ShootingWeights& weights, const Errors& errors) {
  double squares = 0.0;
  for (const Eigen::MatrixXd& window : errors.flights[0].window)
    squares += (weights * (window.col(1) - 2.0 * window.col(0))).squaredNorm();
  return squares / static_cast<double>(errors.flights[0].window.size() * window_rows);
}

ShootingWeights weights_of(Errors errors) {
  const int mass = mass_column(catalogue());
  errors.flights[0].columns = {mass};
  return shooting_weights(errors.flights, {mass}, Eigen::VectorXd::Constant(1, 2.0));
}

// forty windows do not tell 435 correlations between 30 rows: those between axes, which are none, are not taken from chance
TEST(ShootingWeights, OfFewWindowsWhitenOthers) {
  const ShootingWeights weights = weights_of(Errors(40));
  double between = 0.0;
  for (Eigen::Index i = 0; i < window_rows; ++i)
    for (Eigen::Index j = 0; j < window_rows; ++j)
      if (i % 6 != j % 6) between += weights(i, j) * weights(i, j);
  EXPECT_LT(std::sqrt(between), 0.15 * weights.norm());
  EXPECT_NEAR(size_of_white(weights, Errors(4000)), 1.0, 0.35);
}

// an axis that errs with another is known to
TEST(ShootingWeights, KeepWhatAxesHaveInCommon) {
  const auto tied = [](int windows) {
    Errors errors(windows);
    for (Eigen::MatrixXd& window : errors.flights[0].window)
      for (int row = 0; row < window_rows; row += 6)
        window(row + 5, 1) += 3.0 * (window(row, 1) - 2.0 * window(row, 0));
    return errors;
  };
  const ShootingWeights weights = weights_of(tied(200));
  EXPECT_NEAR(size_of_white(weights, tied(4000)), 1.0, 0.2);
  EXPECT_GT(weights.cwiseAbs()(5, 0), 0.2 * weights(5, 5));
}

TEST(ShootingGrams, AreSquaresOfRowsAndAPriorAndHoldLostWindowsDown) {
  const Catalogue all = catalogue();
  Errors errors(2);
  const int mass = mass_column(all), n = all.size();
  errors.flights[0].columns = {mass};
  errors.flights[0].window[0].col(1) = Eigen::VectorXd::Constant(window_rows, 2.0);
  errors.flights[0].window[1].col(1) = Eigen::VectorXd::Constant(window_rows, 30.0);
  Eigen::VectorXd value = all.nominal();
  const Column& column = all.column(mass);
  value[mass] += 0.5 * column.natural;
  const Grams grams = shooting_grams(errors.flights, Eigen::MatrixXd::Identity(window_rows, window_rows), all, value);
  ASSERT_EQ(grams.block.size(), 3u);
  EXPECT_EQ(grams.rows, 2.0 * window_rows);
  EXPECT_NEAR(grams.block[0](n, n), 4.0 * window_rows, 1e-9);
  EXPECT_NEAR(grams.block[0](mass, n), 1.0 * window_rows, 1e-9);
  EXPECT_NEAR(grams.block[0](mass, mass), 0.25 * window_rows, 1e-9);
  // ten times as far as clearly lost: a tenth of its weight
  EXPECT_NEAR(grams.block[1](n, n), 900.0 * window_rows / 10.0, 1e-9);
  EXPECT_NEAR(grams.block[1](mass, n), 15.0 * window_rows / 10.0, 1e-9);
  // beforehand an effect is no more than twenty of its natural sizes from nothing, a nuisance one
  EXPECT_NEAR(grams.block[2](mass, mass), 1.0 / 400.0, 1e-12);
  EXPECT_NEAR(grams.block[2](mass, n), -0.5 / 400.0, 1e-12);
  EXPECT_NEAR(grams.block[2](n, n), 0.25 / 400.0, 1e-12);
  for (int c = 0; c < n; ++c)
    if (const Column& nuisance = all.column(c); nuisance.group < 0) {
      EXPECT_EQ(grams.block[2](c, c), nuisance.of_torque_trim() ? 0.0 : 1.0) << c;  // trims: see torque_trims.hpp
    }
}

// Commands swing about the roll axis. What they ask for is known in closed form, and so is what it does within a window.
FlightData rolled(double amplitude_radps2, double rate_radps) {
  const VehicleModel model = vehicle();
  return test::flight_of(
      model, 20.0, sample_s, [](double) { return Motion{}; },
      [=](double t) {
        // more thrust on one side, less on the other
        const double torque = amplitude_radps2 * std::sin(rate_radps * t) * model.inertia_B_kgm2(0, 0);
        RotorArray speeds = test::all_at(model.hover_speed_radps());
        double levers = 0.0;
        for (const Rotor& rotor : model.rotors) levers += std::pow(rotor.position_B_m.y(), 2);
        for (std::size_t r = 0; r < model.rotors.size(); ++r) {
          const double more_N = torque * model.rotors[r].position_B_m.y() / levers;
          speeds[r] = std::sqrt(speeds[r] * speeds[r] + more_N / model.rotors[r].thrust_coefficient_Ns2);
        }
        return speeds;
      });
}

TEST(Answers, CommandedTorqueTurnsAsItsIntegralSays) {
  constexpr double amplitude = 3.0, rate = 5.0;
  const Catalogue all = catalogue();
  const FlightData flight = rolled(amplitude, rate);
  const ShotFlight shot = shoot(flight, 0, all, all.nominal(), {}, 0.5);
  const std::vector<Eigen::MatrixXd> torque = commanded_torque(flight, shot, 0.0);
  ASSERT_EQ(torque.size(), shot.window.size());
  for (std::size_t w = 0; w < torque.size(); ++w)
    for (std::size_t h = 0; h < shooting_horizon_s.size(); ++h) {
      const auto row = static_cast<Eigen::Index>(h) * 6 + 3;
      const double from = shot.time_s[w] - flight.start_s, to = from + shooting_horizon_s[h];
      EXPECT_NEAR(torque[w](row, 0), amplitude / rate * (std::cos(rate * from) - std::cos(rate * to)),
                  0.04 * amplitude);
      EXPECT_NEAR(torque[w](row, 3), shooting_horizon_s[h], 1e-9);
      EXPECT_NEAR(torque[w].row(row).segment(1, 2).norm() + torque[w].topRows(3).norm(), 0.0, 1e-6);
    }
  // what is smoothed over more than its period is gone, but at the ends of the flight
  const std::vector<Eigen::MatrixXd> smooth = commanded_torque(flight, shot, 1.0);
  for (std::size_t w = 0; w < smooth.size(); ++w) {
    if (shot.time_s[w] < 3.0 || shot.time_s[w] > 16.0) continue;
    EXPECT_LT(smooth[w].leftCols(3).norm(), 0.01 * amplitude) << w;
  }
}

// the air turns the vehicle as far as `answered` of the commanded torque turns it back, and something else does a little
ShotFlight answered_flight(const Catalogue& all, double answered, std::vector<Eigen::MatrixXd>& torque) {
  const FlightData flight = rolled(3.0, 5.0);
  std::vector<int> columns;
  for (int c = 0; c < all.size(); ++c) columns.push_back(c);
  ShotFlight shot = shoot(flight, 0, all, all.nominal(), columns, 0.5);
  torque = commanded_torque(flight, shot, 0.0);
  const RandomStream random(5, 1, "answers");
  for (std::size_t w = 0; w < shot.window.size(); ++w) {
    shot.window[w].rightCols(1) = -answered * torque[w].col(0);
    for (Eigen::Index row = 0; row < window_rows; ++row)
      shot.window[w](row, shot.window[w].cols() - 1) +=
          0.02 * random.normal4(w * window_rows + static_cast<std::uint64_t>(row))[0];
  }
  return shot;
}

TEST(Answers, TheirShareIsHowMuchTheLoopCancels) {
  const Catalogue all = catalogue();
  const ShootingWeights weights = ShootingWeights::Identity(window_rows, window_rows);
  for (const double answered : {0.0, 0.9}) {
    std::vector<Eigen::MatrixXd> torque;
    const ShotFlight shot = answered_flight(all, answered, torque);
    EXPECT_NEAR(answers_of({shot}, {torque}, weights, all, {0}).share[0], -answered, 0.03);
  }
}

TEST(Answers, ThatAreSetAsideLeaveNoTorquePerCommandAndNoAnswer) {
  const Catalogue all = catalogue();
  const ShootingWeights weights = ShootingWeights::Identity(window_rows, window_rows);
  std::vector<Eigen::MatrixXd> torque;
  const ShotFlight before = answered_flight(all, 0.9, torque);
  std::vector<ShotFlight> after{before};
  const Answers answers = answers_of(after, {torque}, weights, all, {0});
  set_aside(answers, weights, all, after);
  const auto norm = [&](const ShotFlight& flight, Eigen::Index column) {
    double sum = 0.0;
    for (const Eigen::MatrixXd& window : flight.window) sum += window.col(column).squaredNorm();
    return std::sqrt(sum);
  };
  const auto column_of = [&](const char* effect) {
    return static_cast<Eigen::Index>(all.group(all.find(effect)).columns.front());
  };
  const auto answered = [&](const ShotFlight& flight) {
    double sum = 0.0;
    for (std::size_t w = 0; w < flight.window.size(); ++w)
      sum += answers.window.front()[w].col(0).dot(flight.window[w].rightCols<1>());
    return sum;
  };
  EXPECT_LT(answered(before), -1.0);
  EXPECT_NEAR(answered(after.front()), 0.0, 1e-9);
  // a moment of inertia is nothing but less torque per command; a mass turns nothing
  EXPECT_LT(norm(after.front(), column_of("inertia")), 0.02 * norm(before, column_of("inertia")));
  EXPECT_EQ(norm(after.front(), column_of("mass")), norm(before, column_of("mass")));
  // thrust keeps its force
  const Eigen::Index thrust = column_of("thrust_scale");
  for (std::size_t w = 0; w < before.window.size(); ++w)
    EXPECT_LT(
        (after.front().window[w].col(thrust) - before.window[w].col(thrust))(Eigen::seq(2, Eigen::last, 6)).norm(),
        1e-9);
}

}  // namespace shooting_test
}  // namespace gustlab::diagnosis
