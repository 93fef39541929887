#include "diagnosis/rollout/replay.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "diagnosis/rollout/per_flight.hpp"
#include "diagnosis/rollout/verify.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/random.hpp"
#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace replay_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;

std::vector<EffectSpec> specs(const std::string& text) {
  config::Table document = config::Table::parse(text, "test");
  return config::read_effects(document);
}

RotorCommand command_at(const VehicleModel& vehicle, double t) {
  RotorCommand command;
  for (std::size_t i = 0; i < 4; ++i)
    command.speed_radps[i] =
        vehicle.hover_speed_radps() *
        (1.0 + 0.01 * std::sin(25.0 * t + 1.7 * static_cast<double>(i)) + 0.03 * std::sin(9.0 * t));
  return command;
}

// three seconds of a vehicle that is shaken, a sample every 10 ms, commands held between samples
FlightLog fly(const VehicleModel& vehicle, const std::vector<EffectSpec>& effects) {
  Plant plant(vehicle, make_effects(effects), {.step_s = 0.001, .seed = 1, .replicate = 1});
  VehicleState state;
  state.position_W_m.z() = 1.0;
  state.velocity_W_mps = Vector3(0.8, -0.4, 0.1);
  state.rotor_speed_radps = command_at(vehicle, 0.0).speed_radps;
  plant.reset(state);

  FlightLog log;
  log.path = "shaken.csv";
  log.meta.hold = Hold::zoh;
  for (const char* name :
       {"px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz", "wx", "wy", "wz", "u1", "u2", "u3", "u4"})
    log.columns.push_back({name, {}});
  for (int k = 0; k < 300; ++k) {
    const double t = 0.01 * k;
    const RotorCommand command = command_at(vehicle, t);
    const Observation seen = plant.observe(false);
    const double row[] = {seen.position_W_m.x(),      seen.position_W_m.y(),      seen.position_W_m.z(),
                          seen.velocity_W_mps.x(),    seen.velocity_W_mps.y(),    seen.velocity_W_mps.z(),
                          seen.attitude_WB.w(),       seen.attitude_WB.x(),       seen.attitude_WB.y(),
                          seen.attitude_WB.z(),       seen.body_rate_B_radps.x(), seen.body_rate_B_radps.y(),
                          seen.body_rate_B_radps.z(), command.speed_radps[0],     command.speed_radps[1],
                          command.speed_radps[2],     command.speed_radps[3]};
    log.time_s.push_back(100.0 + t);
    for (std::size_t c = 0; c < log.columns.size(); ++c) log.columns[c].values.push_back(row[c]);
    for (int step = 0; step < 10; ++step) EXPECT_TRUE(plant.step(command));
  }
  return log;
}

void drop(FlightLog& log, std::initializer_list<const char*> names) {
  std::erase_if(log.columns,
                [&](const LogColumn& c) { return std::find(names.begin(), names.end(), c.name) != names.end(); });
}

double mean(const std::vector<double>& values, std::size_t horizon, std::size_t horizons) {
  double sum = 0.0;
  for (std::size_t i = horizon; i < values.size(); i += horizons) sum += values[i];
  return sum * static_cast<double>(horizons) / static_cast<double>(values.size());
}
double model_error(const FitErrors& errors, FitQuantity quantity, std::size_t horizon) {
  return mean(errors[quantity].model, horizon, errors.horizon_s.size());
}

class Replay : public ::testing::Test {
 protected:
  const VehicleModel vehicle = read_vehicle("crazyflie");
  const FlightLog log = fly(vehicle, vehicle.effects);
};

// what is drawn beside it, the recorded commands, has the times of the log
TEST_F(Replay, TheWindowThatIsDrawnHasTheTimesOfTheLog) {
  const Verification flown = verify({log}, vehicle, {}, 1);
  ASSERT_FALSE(flown.window.empty());
  EXPECT_GT(flown.window.front().time_s.front(), 101.0);
  EXPECT_LT(flown.window.front().time_s.back(), 103.0);
}

TEST(CommonWindows, BeginAtTheSameRow) {
  FitErrors one, other;
  one.start_row = {0, 10, 20, 30};
  other.start_row = {5, 10, 25, 30, 40};
  EXPECT_EQ(common_windows(one, other), (std::vector<std::pair<std::size_t, std::size_t>>{{1, 1}, {3, 3}}));
  EXPECT_TRUE(common_windows(one, FitErrors{}).empty());
}

TEST_F(Replay, OfTheModelThatFlewIsExact) {
  const FitErrors errors = replay(log, vehicle, vehicle.effects, {});
  EXPECT_EQ(errors.windows(), 2u);  // 0 to 1 s and 1 to 2 s; the record ends at 2.99 s
  for (std::size_t h = 0; h < 3; ++h) {
    EXPECT_LT(model_error(errors, FitQuantity::position_m, h), 1e-9);
    EXPECT_LT(model_error(errors, FitQuantity::velocity_mps, h), 1e-9);
    EXPECT_LT(model_error(errors, FitQuantity::attitude_rad, h), 1e-8);
    EXPECT_LT(model_error(errors, FitQuantity::body_rate_radps, h), 1e-7);
  }
}

TEST_F(Replay, HoldIsTheDistanceFromTheStart) {
  ReplayOptions options;
  options.stride = 7;
  const FitErrors errors = replay(log, vehicle, vehicle.effects, options);
  const std::size_t row = errors.start_row.at(3);
  EXPECT_EQ(row, 21u);
  const auto at = [&](const char* name, std::size_t r) { return (*log.find(name))[r]; };
  const Vector3 moved(at("px", row + 50) - at("px", row), at("py", row + 50) - at("py", row),
                      at("pz", row + 50) - at("pz", row));
  EXPECT_DOUBLE_EQ(errors[FitQuantity::position_m].hold[3 * 3 + 1], moved.norm());
}

TEST_F(Replay, AMissingEffectShowsAndThePresentOneDoesNot) {
  const auto without_drag =
      specs("[[effect]]\ntype = 'motor_lag'\ntime_constant = 0.0125\ntime_constant_down = 0.025\n");
  const FitErrors errors = replay(log, vehicle, without_drag, {});
  EXPECT_GT(model_error(errors, FitQuantity::velocity_mps, 1), 0.05);
  EXPECT_GT(model_error(errors, FitQuantity::velocity_mps, 1),
            100.0 * mean(errors[FitQuantity::velocity_mps].noise, 1, 3));
}

TEST_F(Replay, RotorSpeedAtAStartComesFromTheWholeRecordBefore) {
  const auto slow = specs(
      "[[effect]]\ntype = 'motor_lag'\ntime_constant = 0.3\n[[effect]]\ntype = 'actuation_delay'\ndelay = 0.025\n");
  const FlightLog late = fly(vehicle, slow);
  const FitErrors errors = replay(late, vehicle, slow, {});
  EXPECT_LT(model_error(errors, FitQuantity::position_m, 2), 1e-8);
}

TEST_F(Replay, SensorEffectsAreTakenOutOfTheStartAndPutOnThePrediction) {
  for (const char* sensor :
       {"[[effect]]\ntype = 'pose_delay'\ndelay = 0.015\n",
        "[[effect]]\ntype = 'attitude_offset'\nx = 0.03\ny = -0.02\n", "[[effect]]\ntype = 'yaw_offset'\nz = 0.1\n",
        "[[effect]]\ntype = 'gyro_scale'\ndelta = 0.05\n"}) {
    const auto effects = config::merge_effects(vehicle.effects, specs(sensor));
    const FlightLog seen = fly(vehicle, effects);
    ReplayOptions options;
    options.stride = 10;
    const FitErrors with = replay(seen, vehicle, effects, options),
                    without = replay(seen, vehicle, vehicle.effects, options);
    // a late pose leaves the interpolation of the body rate over a sample
    EXPECT_LT(model_error(with, FitQuantity::position_m, 1),
              0.02 * model_error(without, FitQuantity::position_m, 1) + 1e-4)
        << sensor;
    EXPECT_LT(model_error(with, FitQuantity::attitude_rad, 1),
              0.15 * model_error(without, FitQuantity::attitude_rad, 1))
        << sensor;
  }
}

TEST_F(Replay, MeasuredRotorSpeedDrivesTheBodyPastTheCommandsWay) {
  FlightLog measured = log;
  for (int i = 1; i <= 4; ++i)
    measured.columns.push_back({"rotor" + std::to_string(i), *log.find("u" + std::to_string(i))});
  for (int i = 1; i <= 4; ++i)
    for (LogColumn& column : measured.columns)
      if (column.name == "u" + std::to_string(i))
        for (double& value : column.values) value = 0.0;
  const FitErrors errors = replay(measured, vehicle, vehicle.effects, {});
  // commands of zero would fall 4.9 m in the second; a held command read as interpolated and a lag leave little
  EXPECT_LT(model_error(errors, FitQuantity::position_m, 2), 0.2);
}

TEST_F(Replay, WhatTheLogDoesNotHaveIsNotComparedAndIsEstimatedFromThePast) {
  FlightLog poses = log;
  drop(poses, {"vx", "vy", "vz", "wx", "wy", "wz"});
  const FitErrors errors = replay(poses, vehicle, vehicle.effects, {});
  EXPECT_TRUE(std::isnan(errors[FitQuantity::velocity_mps].model[0]));
  EXPECT_TRUE(std::isnan(errors[FitQuantity::body_rate_radps].hold[0]));
  EXPECT_LT(model_error(errors, FitQuantity::position_m, 0), 0.01);
  const auto block = fit_block({errors}, {});
  EXPECT_TRUE(block["velocity_mps"]["before"][0].is_null());
  EXPECT_FALSE(block["position_m"].contains("after"));
}

TEST_F(Replay, WithOnlyTheTotalThrustTheRecordedAttitudeIsTakenAsGiven) {
  FlightLog total = log;
  total.meta.actuator = ActuatorKind::collective_thrust;
  std::vector<double> thrust(log.rows());
  for (std::size_t k = 0; k < log.rows(); ++k)
    for (int i = 1; i <= 4; ++i) thrust[k] += 1.7965e-8 * std::pow((*log.find("u" + std::to_string(i)))[k], 2);
  drop(total, {"u1", "u2", "u3", "u4"});
  total.columns.push_back({"u1", thrust});
  const FitErrors errors = replay(total, vehicle, vehicle.effects, {});
  EXPECT_TRUE(std::isnan(errors[FitQuantity::attitude_rad].model[0]));
  EXPECT_LT(model_error(errors, FitQuantity::position_m, 1), 0.01);
}

TEST_F(Replay, WindowsKeepClearOfGaps) {
  FlightLog gap = log;
  for (std::size_t k = 150; k < gap.rows(); ++k) gap.time_s[k] += 0.5;
  ReplayOptions options;
  options.stride = 1;
  options.horizon_s = {0.1, 0.5};
  const FitErrors errors = replay(gap, vehicle, vehicle.effects, options);
  EXPECT_EQ(errors.windows(), 200u);
  for (const std::size_t row : errors.start_row) EXPECT_TRUE(row < 100 || row >= 150);
}

TEST_F(Replay, EveryNumberOfThreadsGivesTheSameBytes) {
  ReplayOptions one, four;
  one.stride = four.stride = 5;
  four.jobs = 4;
  const std::string a = fit_block({replay(log, vehicle, vehicle.effects, one)}, {}).dump();
  const std::string b = fit_block({replay(log, vehicle, vehicle.effects, four)}, {}).dump();
  EXPECT_EQ(a, b);
}

TEST_F(Replay, TheCallerMayKnowTheStartBetter) {
  ReplayOptions options;
  options.correct_start = [](std::size_t, VehicleState& state) { state.position_W_m.x() += 0.5; };
  const FitErrors errors = replay(log, vehicle, vehicle.effects, options);
  EXPECT_NEAR(model_error(errors, FitQuantity::position_m, 0), 0.5, 1e-9);
}

TEST_F(Replay, WithoutAttitudeOrALongEnoughStretchThereIsNoRollout) {
  FlightLog blind = log;
  drop(blind, {"qw"});
  EXPECT_THROW(replay(blind, vehicle, vehicle.effects, {}), DataError);
  ReplayOptions options;
  options.horizon_s = {5.0};
  EXPECT_THROW(replay(log, vehicle, vehicle.effects, options), DataError);
}

// x, y, z of the last effect, from what the samples up to a time say
Vector3 told(const FlightLog& log, const VehicleModel& vehicle, const std::vector<EffectSpec>& effects, double time_s) {
  const Recording recording(log, vehicle, {});
  const PerFlightFit fit(recording, effects, Rollout(recording, effects).rotor_speeds(), true, 1);
  const EffectSpec last = fit.effects(fit.known_by(recording.motion.nearest(time_s))).back();
  Vector3 value;
  for (int axis = 0; axis < 3; ++axis) value[axis] = std::stod(last.values.at(static_cast<std::size_t>(axis)).second);
  return value;
}

TEST_F(Replay, AWindThatTheModelDoesNotKnowIsToldFromThePast) {
  const auto windy =
      config::merge_effects(vehicle.effects, specs("[[effect]]\ntype = 'steady_wind'\nx = 0.5\ny = -0.3\n"));
  const auto still = config::merge_effects(vehicle.effects, specs("[[effect]]\ntype = 'steady_wind'\n"));
  const FlightLog flown = fly(vehicle, windy);
  EXPECT_EQ(told(flown, vehicle, still, 0.4), Vector3(0.0, 0.0, 0.0));  // nothing has ended yet
  for (const double time_s : {1.1, 2.5}) {
    const Vector3 wind_W_mps = told(flown, vehicle, still, time_s);
    EXPECT_NEAR(wind_W_mps.x(), 0.5, 0.02) << time_s;
    EXPECT_NEAR(wind_W_mps.y(), -0.3, 0.02) << time_s;
  }
  // the second window has seen two rollouts; the first knows nothing
  const FitErrors errors = replay(flown, vehicle, still, {});
  const auto& position = errors[FitQuantity::position_m].model;
  EXPECT_LT(position[3 + 2], 0.05 * position[2]);
}

TEST_F(Replay, AForceUnderSensorNoiseIsToldAsWellAsTheAttitudeIsKnown) {
  FlightLog noisy = fly(
      vehicle,
      config::merge_effects(vehicle.effects, specs("[[effect]]\ntype = 'constant_force'\nx = 0.006\ny = -0.004\n")));
  const RandomStream stream(3, 0, "test_noise");
  const double attitude_sd = 0.002;
  for (std::size_t row = 0; row < noisy.rows(); ++row)
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const auto draw = stream.normal4(row, axis);
      noisy.columns[axis].values[row] += 0.0005 * draw[0];
      noisy.columns[3 + axis].values[row] += 0.002 * draw[1];
      noisy.columns[7 + axis].values[row] += 0.5 * attitude_sd * draw[2];
      noisy.columns[10 + axis].values[row] += 0.01 * draw[3];
    }
  const auto free = config::merge_effects(vehicle.effects, specs("[[effect]]\ntype = 'constant_force'\n"));
  const Vector3 force_W_N = told(noisy, vehicle, free, 2.5);
  // a tilt is a force: weight times attitude error, over five rollouts; four deviations
  const double bound_N = 4.0 * vehicle.weight_N() * attitude_sd / std::sqrt(5.0);
  EXPECT_NEAR(force_W_N.x(), 0.006, bound_N);
  EXPECT_NEAR(force_W_N.y(), -0.004, bound_N);
}

TEST_F(Replay, WhatComesAfterAWindowsStartTellsNothing) {
  const auto still = config::merge_effects(vehicle.effects, specs("[[effect]]\ntype = 'steady_wind'\n"));
  FlightLog changed =
      fly(vehicle, config::merge_effects(vehicle.effects, specs("[[effect]]\ntype = 'steady_wind'\nx = 0.5\n")));
  const Vector3 before = told(changed, vehicle, still, 1.55);
  for (std::size_t row = 156; row < changed.rows(); ++row)
    for (std::size_t c = 3; c < 6; ++c) changed.columns[c].values[row] += 0.3;
  EXPECT_EQ(told(changed, vehicle, still, 1.55), before);
  EXPECT_NE(told(changed, vehicle, still, 2.1), before);
}

// keeps some rows of some columns and leaves the other cells empty
template <class Kept>
void keep_rows(FlightLog& log, std::initializer_list<std::string_view> names, Kept kept) {
  for (LogColumn& column : log.columns)
    if (std::find(names.begin(), names.end(), column.name) != names.end())
      for (std::size_t row = 0; row < log.rows(); ++row)
        if (!kept(row)) column.values[row] = std::nan("");
}

void make_slow(FlightLog& log, std::initializer_list<std::string_view> names, std::size_t every) {
  keep_rows(log, names, [every](std::size_t row) { return row % every == 0; });
}

// GIVEN gyro and commands in every row, poses in three of five, and none for 80 ms WHEN replayed THEN windows go on across what is missing
TEST_F(Replay, MissingPosesBreakNoWindow) {
  FlightLog poses = log;
  keep_rows(poses, {"px", "py", "pz", "vx", "vy", "vz", "qw", "qx", "qy", "qz"},
            [](std::size_t row) { return row % 5 < 3 && (row < 153 || row >= 160); });
  const FitErrors errors = replay(poses, vehicle, vehicle.effects, {});
  EXPECT_EQ(errors.windows(), 2u);
  for (std::size_t h = 0; h < 3; ++h) EXPECT_LT(model_error(errors, FitQuantity::position_m, h), 1e-9);

  // a velocity that must be estimated from few positions is no start: 162 has two beside it, and those before the gap
  drop(poses, {"vx", "vy", "vz"});
  ReplayOptions options;
  options.stride = 1;
  const FitErrors estimated = replay(poses, vehicle, vehicle.effects, options);
  EXPECT_THAT(estimated.start_row, AllOf(Contains(94u), Not(Contains(95u))));
  EXPECT_LT(model_error(estimated, FitQuantity::position_m, 0), 0.01);
}

// GIVEN some empty cells in a log whose rows hold everything else WHEN replayed THEN they break no window
TEST_F(Replay, EmptyCellsBreakNoWindow) {
  FlightLog holes = log;
  keep_rows(holes, {"px", "py", "pz"}, [](std::size_t row) { return row % 40 != 20; });
  EXPECT_EQ(replay(holes, vehicle, vehicle.effects, {}).windows(), 2u);
}

// GIVEN rows that are lost for 50 ms, commands too WHEN replayed THEN the last commands hold until there are others
TEST_F(Replay, CommandsHoldThroughAShortGap) {
  FlightLog gap = log;
  const auto lost = [](auto& values) { values.erase(values.begin() + 150, values.begin() + 154); };
  lost(gap.time_s);
  for (LogColumn& column : gap.columns) lost(column.values);
  const FitErrors errors = replay(gap, vehicle, vehicle.effects, {});
  EXPECT_THAT(errors.start_row, ElementsAre(0u, 104u));  // across the gap; of 100 to 103 an end is lost
  EXPECT_LT(model_error(errors, FitQuantity::position_m, 2), 0.1 * mean(errors[FitQuantity::position_m].hold, 2, 3));
}

// as flight computers log: attitude at half, position at a fifth of the rate of the gyro
TEST_F(Replay, ColumnsMayHaveRatesOfTheirOwn) {
  const FlightLog whole = fly(vehicle, vehicle.effects);
  FlightLog slow = whole;
  make_slow(slow, {"qw", "qx", "qy", "qz"}, 2);
  make_slow(slow, {"px", "py", "pz", "vx", "vy", "vz"}, 5);
  const FitErrors errors = replay(slow, vehicle, vehicle.effects, {}),
                  exact = replay(whole, vehicle, vehicle.effects, {});
  ASSERT_GE(errors.windows(), exact.windows());
  const nlohmann::ordered_json fit = fit_block({errors}, {});
  for (const char* quantity : {"position_m", "velocity_mps", "attitude_rad", "body_rate_radps"})
    for (std::size_t h = 0; h < 2; ++h)
      EXPECT_LT(fit[quantity]["before"][h].get<double>(), 0.1 * fit[quantity]["hold"][h].get<double>())
          << quantity << " at horizon " << h;
}

TEST_F(Replay, LaterInputsKeepTheirEmptyCells) {
  FlightLog slow = fly(vehicle, vehicle.effects);
  make_slow(slow, {"u1"}, 5);
  const FlightLog later = with_later_inputs(slow, 0.02);
  const auto &before = *slow.find("u1"), &after = *later.find("u1");
  for (std::size_t row = 5; row + 5 < slow.rows(); ++row) {
    ASSERT_EQ(std::isnan(after[row]), row % 5 != 0) << row;
    if (row % 5 == 0) {
      EXPECT_NEAR(after[row], 0.6 * before[row] + 0.4 * before[row - 5], 1e-9 * before[row]) << row;
    }
  }
}

}  // namespace replay_test
}  // namespace gustlab::diagnosis
