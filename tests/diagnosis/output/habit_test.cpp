// What is no physics is fitted as rollouts, offered where the recorded actuators do not predict turning, and called a habit.
#include <gmock/gmock.h>

#include <cmath>

#include "diagnosis/output/habit.hpp"
#include "support/trials.hpp"

namespace gustlab::diagnosis {
namespace habit_test {

// pieces of a second of a loop with this habit, each from another state
FlightData turned_by(const Habit& habit) {
  FlightData flight;
  flight.sample_s = 0.01;
  double time_s = 0.0;
  for (int piece = 0; piece < 120; ++piece) {
    const auto kick = [&](double by) { return std::sin(1.7 * piece * by + by); };
    Motion m;
    m.body_rate_B_radps = Vector3(kick(1.0), kick(2.3), kick(3.1));
    m.attitude_WB =
        Quaternion(Eigen::AngleAxisd(0.4 * kick(0.7), Vector3(kick(0.3), kick(1.9), 0.2 * kick(2.9)).normalized()));
    m.velocity_W_mps = Vector3(kick(1.3), kick(2.7), 0.3 * kick(0.9));
    for (int k = 0; k < 70; ++k, time_s += flight.sample_s) {
      Sample sample;
      sample.time_s = time_s;
      sample.starts_segment = k == 0;
      const Matrix3 R = m.attitude_WB.toRotationMatrix();
      const Vector3 velocity = R.transpose() * m.velocity_W_mps;
      Eigen::Matrix<double, 8, 1> terms;
      terms << m.body_rate_B_radps, R(2, 0), R(2, 1), velocity.x(), velocity.y(), 1.0;
      m.acceleration_W_mps2 = R.col(2) * 9.81 - 9.81 * Vector3::UnitZ();
      flight.samples.push_back(sample);
      flight.motion.push_back(m);
      const Vector3 turning = habit.transpose() * terms, middle = m.body_rate_B_radps + 0.5 * flight.sample_s * turning;
      m.attitude_WB =
          m.attitude_WB * Quaternion(Eigen::AngleAxisd(flight.sample_s * middle.norm(), middle.normalized()));
      m.velocity_W_mps += flight.sample_s * m.acceleration_W_mps2;
      m.body_rate_B_radps += flight.sample_s * turning;
    }
    time_s += 1.0;
  }
  return flight;
}

TEST(Habit, IsFoundFromWholeRollouts) {
  Habit habit = Habit::Zero();
  habit.col(0) << -6.0, 0.5, 0.0, 0.0, -8.0, 0.0, 1.5, 0.2;
  habit.col(1) << 0.0, -4.0, 1.0, 7.0, 0.0, -2.0, 0.0, 0.0;
  habit.col(2) << 0.0, 0.3, -3.0, 0.0, 0.0, 0.0, 0.0, -0.1;
  const Habit found = fit_habit({turned_by(habit)}, 2);
  EXPECT_LT((found - habit).cwiseAbs().maxCoeff(), 0.05) << found;
  EXPECT_EQ(found, fit_habit({turned_by(habit)}, 1));
}

DiagnoseOptions flown(const TemporaryFolder& folder) {
  test::TrialSettings trial;
  trial.fit = {"multisine", "lemniscate"};
  trial.holdout = {"multisine"};
  trial.concealed = R"({type = "mass", delta = 0.06})";
  return test::fly_trial(folder, trial);
}

TEST(HabitTrials, IsNotOfferedWherePhysicsPredictsTurning) {
  const TemporaryFolder folder;
  const Diagnosis d = diagnose(flown(folder));
  EXPECT_TRUE(d.habit.is_null());
  EXPECT_EQ(d.augmented_toml.find("recorded_loop"), std::string::npos);
}

// rotor speeds that wander by a few percent, each by itself, predict no turning
TEST(HabitTrials, IsOfferedWhereActuatorsPredictNoneAndIsCalledOne) {
  const TemporaryFolder folder;
  const DiagnoseOptions options = flown(folder);
  for (const auto* paths : {&options.fit, &options.holdout})
    for (const std::string& path : *paths) {
      FlightLog log = read_flight_log(path);
      for (LogColumn& column : log.columns)
        if (column.name.starts_with('u') && column.name.size() == 2)
          for (std::size_t k = 0; k < log.rows(); ++k)
            column.values[k] *= 1.0 + 0.03 * std::sin(2.0 * log.time_s[k] + 1.9 * (column.name[1] - '0'));
      write_flight_log(log, path);
    }
  const Diagnosis d = diagnose(options);
  ASSERT_FALSE(d.habit.is_null()) << to_json(d).dump(1);
  EXPECT_THAT(d.habit.at("says").get<std::string>(), testing::HasSubstr("no physics"));
  EXPECT_NE(d.augmented_toml.find("recorded_loop"), std::string::npos);
  const auto& with = d.habit.at("fit").at("body_rate_radps");
  EXPECT_LT(with[1].get<double>(), d.fit.at("body_rate_radps").at("hold")[1].get<double>());
  // the fit block stays that of physics
  EXPECT_GT(d.fit.at("body_rate_radps").at("after")[1].get<double>(),
            d.fit.at("body_rate_radps").at("hold")[1].get<double>());
}

}  // namespace habit_test
}  // namespace gustlab::diagnosis
