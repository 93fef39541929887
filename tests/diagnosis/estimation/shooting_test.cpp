// Predictions half a second ahead of a flight that accelerates as nobody expects, and the weights of their windows.
#include "diagnosis/estimation/shooting.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace {

constexpr double sample_s = 0.02, extra_mps2 = 0.3;
constexpr int window_rows = 30;

VehicleModel vehicle() {
  VehicleModel model = test::ring(4, 1.5, 0.25, 0.0);
  model.effects.clear();
  return model;
}

Catalogue catalogue() { return {vehicle(), 1, {.told = Need::attitude | Need::motion | Need::torque, .trims = true}}; }

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

int mass_column(const Catalogue& all) {
  return all.groups()[static_cast<std::size_t>(all.find("mass"))].columns.front();
}

// what is missed grows with the horizon as a t, and what a mass changes as −g t
TEST(Shooting, MissesWhatNobodyExpectsAndKnowsWhatAMassWouldDo) {
  const Catalogue all = catalogue();
  const int mass = mass_column(all);
  const ShotFlight shot = shoot(climb(), 0, all, all.nominal(), {mass}, 0.5);
  ASSERT_GE(shot.window.size(), 5u);
  ASSERT_EQ(shot.columns, std::vector<int>{mass});
  const double natural = all.columns()[static_cast<std::size_t>(mass)].natural;
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

TEST(ShootingGrams, AreSquaresOfRowsAndAPriorAndHoldLostWindowsDown) {
  const Catalogue all = catalogue();
  Errors errors(2);
  const int mass = mass_column(all), n = all.size();
  errors.flights[0].columns = {mass};
  errors.flights[0].window[0].col(1) = Eigen::VectorXd::Constant(window_rows, 2.0);
  errors.flights[0].window[1].col(1) = Eigen::VectorXd::Constant(window_rows, 30.0);
  Eigen::VectorXd value = all.nominal();
  const Column& column = all.columns()[static_cast<std::size_t>(mass)];
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
    if (all.columns()[static_cast<std::size_t>(c)].group < 0) {
      EXPECT_EQ(grams.block[2](c, c), 1.0) << c;
    }
}

}  // namespace
}  // namespace gustlab::diagnosis
