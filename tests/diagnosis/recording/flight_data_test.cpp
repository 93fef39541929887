// Reading a log whose sensors have rates of their own.
#include "diagnosis/recording/flight_data.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "diagnosis/recording/recorded_motion.hpp"
#include "gustlab/random.hpp"
#include "util/rotations.hpp"
#include "vehicle/read_vehicle.hpp"

namespace gustlab::diagnosis {
namespace flight_data_test {

constexpr double spin_radps = 2.0, step_s = 0.004;

Quaternion attitude(double time_s) {
  return Quaternion(Eigen::AngleAxisd(spin_radps * time_s, Vector3::UnitZ()) *
                    Eigen::AngleAxisd(0.2, Vector3::UnitX()));
}

// two turns about the vertical, the attitude in every second row, by the sign that makes its scalar positive
FlightLog spin() {
  FlightLog log;
  log.path = "somewhere/spin.csv";
  log.meta.hold = Hold::zoh;
  for (const char* name : {"qw", "qx", "qy", "qz", "wx", "wy", "wz", "u1", "u2", "u3", "u4"})
    log.columns.push_back({name, {}});
  const Vector3 rate = attitude(0.0).conjugate() * Vector3(0.0, 0.0, spin_radps);
  for (std::size_t k = 0; k < 1600; ++k) {
    const double t = step_s * static_cast<double>(k);
    log.time_s.push_back(t);
    Eigen::Vector4d q(attitude(t).w(), attitude(t).x(), attitude(t).y(), attitude(t).z());
    if (q[0] < 0.0) q = -q;
    if (k % 2 == 1) q.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < 4; ++i) log.columns[i].values.push_back(q[static_cast<int>(i)]);
    for (std::size_t i = 0; i < 3; ++i) log.columns[4 + i].values.push_back(rate[static_cast<int>(i)]);
    for (std::size_t i = 0; i < 4; ++i) log.columns[7 + i].values.push_back(1000.0);
  }
  return log;
}

double worst_attitude_rad(const FlightData& flight) {
  double worst = 0.0;
  for (std::size_t k = 0; k < flight.samples.size(); ++k)
    worst = std::max(worst, flight.motion[k].attitude_WB.angularDistance(attitude(flight.samples[k].time_s)));
  return worst;
}

// GIVEN an attitude that turns through 180 degrees, with rows between that have none WHEN read THEN no sample is off by a sign
TEST(FlightData, AttitudeIsContinuousAcrossRowsWithoutOne) {
  const VehicleModel vehicle = read_vehicle("crazyflie", "");
  EXPECT_LT(worst_attitude_rad(prepare_flight(spin(), vehicle, {})), 1e-3);
  ReadingOptions smoothed;
  smoothed.max_rate_hz = 20.0;
  smoothed.common_filter_s = 0.022;
  EXPECT_LT(worst_attitude_rad(prepare_flight(spin(), vehicle, smoothed)), 5e-2);
}

// the same spin, the attitude at 200 Hz in rows of its own between those of gyro and commands at 250 Hz
FlightLog rows_apart() {
  const FlightLog together = spin();
  FlightLog log = together;
  log.time_s.clear();
  for (LogColumn& column : log.columns) column.values.clear();
  std::size_t row = 0;
  for (int pose = 0; pose < 1270; ++pose) {
    const double pose_s = 0.0013 + 0.005 * pose;
    for (; together.time_s[row] < pose_s; ++row) {
      log.time_s.push_back(together.time_s[row]);
      for (std::size_t c = 0; c < log.columns.size(); ++c)
        log.columns[c].values.push_back(c < 4 ? std::numeric_limits<double>::quiet_NaN()
                                              : together.columns[c].values[row]);
    }
    log.time_s.push_back(pose_s);
    const Quaternion q = attitude(pose_s);
    const double values[] = {q.w(), q.x(), q.y(), q.z()};
    for (std::size_t c = 0; c < log.columns.size(); ++c)
      log.columns[c].values.push_back(c < 4 ? values[c] : std::numeric_limits<double>::quiet_NaN());
  }
  return log;
}

// a bias and a scale of the gyroscope are taken out of what was smoothed: as if they were taken out of the samples, in any order
TEST(FlightData, AGyroscopesFaultsAreTakenOutAsOfTheSamples) {
  const FlightData recorded = prepare_flight(spin(), read_vehicle("crazyflie", ""), {});
  SensorCorrection fault, late;
  fault.rate_bias_B_radps = Vector3(0.3, -0.2, 0.1);
  fault.rate_scale = late.rate_scale = 0.05;
  late.pose_delay_s = 0.01;
  FlightData of_samples = recorded, of_smoothed = recorded;
  for (Sample& sample : of_samples.samples)
    sample.body_rate_B_radps = (sample.body_rate_B_radps - fault.rate_bias_B_radps) / 1.05;
  of_samples.gyro.clear();
  smooth_motion(of_samples, {});
  smooth_motion(of_smoothed, late);
  smooth_motion(of_smoothed, fault);
  for (std::size_t k = 0; k < recorded.samples.size(); ++k) {
    const Motion &a = of_samples.motion[k], &b = of_smoothed.motion[k];
    EXPECT_LT((a.body_rate_B_radps - b.body_rate_B_radps).norm(), 1e-9);
    EXPECT_LT((a.angular_acceleration_B_radps2 - b.angular_acceleration_B_radps2).norm(), 1e-7);
    EXPECT_EQ(a.attitude_WB.coeffs(), b.attitude_WB.coeffs());
  }
  EXPECT_GT((recorded.motion[100].body_rate_B_radps - of_smoothed.motion[100].body_rate_B_radps).norm(), 0.1);
}

// GIVEN a wobbling spin without its gyroscope, or without its attitude WHEN smoothed THEN the missing one follows from the other
TEST(FlightData, RateAndAttitudeStandInForEachOther) {
  FlightLog log = spin();
  for (std::size_t k = 0; k < log.time_s.size(); ++k) log.columns[4].values[k] += 0.1 * std::sin(7.0 * log.time_s[k]);
  const auto without = [&](std::size_t from, std::size_t to) {
    FlightLog rest = log;
    rest.columns.erase(rest.columns.begin() + static_cast<std::ptrdiff_t>(from),
                       rest.columns.begin() + static_cast<std::ptrdiff_t>(to));
    return prepare_flight(rest, read_vehicle("crazyflie", ""), {});
  };
  const FlightData whole = without(0, 0), no_gyro = without(4, 7), no_attitude = without(0, 4);
  for (std::size_t k = 1; k + 1 < whole.samples.size(); ++k)
    EXPECT_EQ(whole.motion[k].angular_acceleration_B_radps2, whole.gyro[k].acceleration_B_radps2) << k;
  for (std::size_t k = 1; k + 1 < no_gyro.samples.size(); ++k) {
    const Vector3 change = no_gyro.motion[k + 1].body_rate_B_radps - no_gyro.motion[k - 1].body_rate_B_radps;
    const double while_s = no_gyro.samples[k + 1].time_s - no_gyro.samples[k - 1].time_s;
    EXPECT_EQ(no_gyro.motion[k].angular_acceleration_B_radps2, change / while_s) << k;
  }
  for (std::size_t k = 1; k < no_attitude.samples.size(); ++k) {
    const Motion &before = no_attitude.motion[k - 1], &now = no_attitude.motion[k];
    const double step = no_attitude.samples[k].time_s - no_attitude.samples[k - 1].time_s;
    EXPECT_LT((turn_between(before.attitude_WB, now.attitude_WB) - step * before.body_rate_B_radps).norm(), 1e-9) << k;
    EXPECT_NE(now.angular_acceleration_B_radps2, Vector3::Zero()) << k;
  }
}

// samples that lie alike share the weights of a fit, others have their own: a cubic is itself, however it was sampled
TEST(FlightData, ACubicPathIsItsOwnLocalFitAtEvenAndUnevenTimes) {
  FlightData flight;
  flight.sample_s = 0.01;
  double t = 0.0;
  for (int k = 0; k < 400; ++k) {
    Sample sample;
    sample.time_s = t;
    sample.channels = has_position;
    sample.starts_segment = k == 0;
    sample.position_W_m = Vector3(t * t * t, 1.0 - 2.0 * t * t, t);
    flight.samples.push_back(sample);
    t += k >= 100 && k < 200 ? 0.01 + 0.004 * std::sin(0.7 * k) : k < 300 ? 0.01 : 0.02;
  }
  smooth_motion(flight, {});
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const double at = flight.samples[k].time_s;
    const Motion& motion = flight.motion[k];
    EXPECT_LT((motion.position_W_m - flight.samples[k].position_W_m).norm(), 1e-6) << k;
    EXPECT_LT((motion.velocity_W_mps - Vector3(3.0 * at * at, -4.0 * at, 1.0)).norm(), 1e-5) << k;
    EXPECT_LT((motion.acceleration_W_mps2 - Vector3(6.0 * at, -4.0, 0.0)).norm(), 1e-3) << k;
  }
}

// An attitude that is turned alone is smoothed alone: with what was smoothed before it is the motion that all together give.
TEST(FlightData, ATurnedAttitudeIsSmoothedAloneAsWithAllElse) {
  SensorCorrection turned_late, turned_other_way;
  turned_late.attitude_offset_B_rad = Vector3(0.05, 0.0, 0.02);
  turned_late.pose_delay_s = turned_other_way.pose_delay_s = 0.01;
  turned_other_way.attitude_offset_B_rad = Vector3(-0.03, 0.01, 0.0);
  FlightData in_parts = prepare_flight(spin(), read_vehicle("crazyflie", ""), {}), at_once = in_parts;
  smooth_motion(in_parts, turned_late);
  smooth_motion(in_parts, turned_other_way);
  at_once.gyro.clear();
  smooth_motion(at_once, turned_other_way);
  for (std::size_t k = 0; k < at_once.samples.size(); ++k) {
    const Motion &a = in_parts.motion[k], &b = at_once.motion[k];
    EXPECT_EQ(a.attitude_WB.coeffs(), b.attitude_WB.coeffs());
    EXPECT_EQ(a.body_rate_B_radps, b.body_rate_B_radps);
    EXPECT_EQ(a.angular_acceleration_B_radps2, b.angular_acceleration_B_radps2);
    EXPECT_EQ(a.position_W_m, b.position_W_m);
  }
}

// GIVEN sensors that never share a row WHEN read THEN the flight is one stretch, and its whole motion is known at the attitude's rows
TEST(FlightData, SensorsMayHaveRowsOfTheirOwn) {
  const FlightLog log = rows_apart();
  const FlightData flight = prepare_flight(log, read_vehicle("crazyflie", ""), {});
  EXPECT_EQ(
      std::count_if(flight.samples.begin(), flight.samples.end(), [](const Sample& s) { return s.starts_segment; }), 1);
  EXPECT_LT(worst_attitude_rad(flight), 1e-3);
  const FlightLog shared = with_shared_rows(log);
  const RecordedMotion motion(shared);
  ASSERT_EQ(motion.rows(), 1270u);
  for (const std::size_t row : {std::size_t{10}, std::size_t{800}}) {
    EXPECT_TRUE(motion.complete(row));
    EXPECT_NEAR(motion.body_rate_B_radps(row).norm(), spin_radps, 1e-6);
    EXPECT_LT(motion.attitude_WB(row).angularDistance(attitude(shared.time_s[row])), 1e-9);
  }
}

// GIVEN a battery whose voltage has rows of its own WHEN read THEN every sample has the last one until then
TEST(FlightData, ABatteryMayHaveRowsOfItsOwn) {
  FlightLog log = rows_apart();
  log.columns.push_back({"vbat", std::vector<double>(log.rows(), std::numeric_limits<double>::quiet_NaN())});
  for (const auto& [time_s, volts] : {std::pair{1.0004, 4.1}, {3.0004, 3.8}, {5.0004, 3.6}}) {
    const auto row = std::lower_bound(log.time_s.begin(), log.time_s.end(), time_s) - log.time_s.begin();
    log.time_s.insert(log.time_s.begin() + row, time_s);
    for (LogColumn& column : log.columns)
      column.values.insert(column.values.begin() + row,
                           column.name == "vbat" ? volts : std::numeric_limits<double>::quiet_NaN());
  }
  const FlightData flight = prepare_flight(log, read_vehicle("crazyflie", ""), {});
  ASSERT_TRUE(flight.has_voltage);
  for (const Sample& sample : flight.samples)
    ASSERT_EQ(sample.voltage_V, sample.time_s < 3.0004 ? 4.1 : sample.time_s < 5.0004 ? 3.8 : 3.6) << sample.time_s;
}

// GIVEN two sensors of 125 Hz, a fifth of a millisecond apart WHEN read THEN it is no log of 5 kHz
TEST(FlightData, RowsThatNearlyMeetAreNoFasterLog) {
  FlightLog log = spin();
  for (std::size_t k = 0; k < log.rows(); ++k) {
    log.time_s[k] = k % 2 == 0 ? 2.0 * step_s * static_cast<double>(k / 2) : log.time_s[k - 1] + 0.0002;
    for (std::size_t c = 4; c < log.columns.size() && k % 2 == 0; ++c)
      log.columns[c].values[k] = std::numeric_limits<double>::quiet_NaN();
  }
  const FlightData flight = prepare_flight(log, read_vehicle("crazyflie", ""), {});
  EXPECT_NEAR(flight.sample_s, step_s, 1e-5);
  EXPECT_EQ(
      std::count_if(flight.samples.begin(), flight.samples.end(), [](const Sample& s) { return s.starts_segment; }), 1);
  EXPECT_EQ(std::count_if(flight.samples.begin(), flight.samples.end(),
                          [](const Sample& s) { return (s.channels & has_attitude) != 0; }),
            800);
}

// GIVEN an attitude in every second row of the gyro WHEN its motion is read THEN it is whole in the attitude's rows
TEST(FlightData, ASlowAttitudeGivesTheRows) {
  const FlightLog shared = with_shared_rows(spin());
  const RecordedMotion motion(shared);
  ASSERT_EQ(motion.rows(), 800u);
  EXPECT_TRUE(motion.complete(400));
  EXPECT_EQ(motion.stretch(799), 0u);
}

// GIVEN poses at uneven intervals on a quick circle WHEN read THEN their noise is what was added, and nothing of the motion
TEST(FlightData, NoiseIsToldAtUnevenIntervals) {
  constexpr double position_sd_m = 3e-4, attitude_sd_rad = 2e-3;
  FlightLog log;
  for (const char* name : {"px", "py", "pz", "qw", "qx", "qy", "qz"}) log.columns.push_back({name, {}});
  const RandomStream random(2, 0, "uneven_noise");
  double t = 0.0;
  for (std::uint64_t k = 0; k < 2000; ++k) {
    t += 0.01 * static_cast<double>(1 + k % 3);
    const auto p = random.normal4(k, 0), q = random.normal4(k, 1);
    const Quaternion turned =
        Quaternion(Eigen::AngleAxisd(0.5 * std::sin(3.0 * t), Vector3::UnitX())) *
        Quaternion(1.0, 0.5 * attitude_sd_rad * q[0], 0.5 * attitude_sd_rad * q[1], 0.5 * attitude_sd_rad * q[2]);
    const double row[] = {0.5 * std::cos(3.0 * t) + position_sd_m * p[0],
                          0.5 * std::sin(3.0 * t) + position_sd_m * p[1],
                          position_sd_m * p[2],
                          turned.w(),
                          turned.x(),
                          turned.y(),
                          turned.z()};
    log.time_s.push_back(t);
    for (std::size_t c = 0; c < log.columns.size(); ++c) log.columns[c].values.push_back(row[c]);
  }
  const RecordedMotion motion(log);
  EXPECT_NEAR(motion.noise()[0], position_sd_m, 0.1 * position_sd_m);
  EXPECT_NEAR(motion.noise()[2], attitude_sd_rad, 0.1 * attitude_sd_rad);
}

// GIVEN a log whose rows hold everything WHEN its motion is read THEN it is left as it is
TEST(FlightData, SharedRowsStay) {
  FlightLog log = spin();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 1; k < log.rows(); k += 2) log.columns[i].values[k] = log.columns[i].values[k - 1];
  EXPECT_EQ(with_shared_rows(log).rows(), log.rows());
}

// at rest: noisy positions at 100 Hz in rows of their own, gyro and commands at 500 Hz
FlightLog slow_noisy_positions() {
  FlightLog log;
  log.path = "somewhere/rest.csv";
  log.meta.hold = Hold::zoh;
  for (const char* name : {"px", "py", "pz", "wx", "wy", "wz", "u1", "u2", "u3", "u4"})
    log.columns.push_back({name, {}});
  const RandomStream random(1, 0, "position_noise");
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t k = 0; k < 4000; ++k) {
    const bool position = k % 5 == 3;
    for (int own = 0; own < (position ? 2 : 1); ++own) {
      log.time_s.push_back(0.002 * static_cast<double>(k) + 0.0007 * own);
      const auto noise = random.normal4(k);
      for (std::size_t c = 0; c < 3; ++c) log.columns[c].values.push_back(own == 1 ? 5e-4 * noise[c] : nan);
      for (std::size_t c = 3; c < 6; ++c) log.columns[c].values.push_back(own == 1 ? nan : 0.0);
      for (std::size_t c = 6; c < 10; ++c) log.columns[c].values.push_back(own == 1 ? nan : 1000.0);
    }
  }
  return log;
}

// GIVEN a fast sensor and a slow one with rows of its own WHEN read at half of the fast one's rate THEN every sample of the slow one is there
TEST(FlightData, ASlowSensorIsReadWhole) {
  const FlightData flight = prepare_flight(slow_noisy_positions(), read_vehicle("crazyflie", ""), {});
  const auto with = [&](unsigned channel) {
    return std::count_if(flight.samples.begin(), flight.samples.end(),
                         [channel](const Sample& s) { return (s.channels & channel) != 0; });
  };
  EXPECT_EQ(with(has_position), 800);
  EXPECT_NEAR(static_cast<double>(with(has_rate)), 2000.0, 2.0);
}

double rates_read_coarsely(const FlightLog& log) {
  ReadingOptions options;
  options.coarse_rate_hz = 130.0;
  const FlightData flight = prepare_flight(log, read_vehicle("crazyflie", ""), options);
  return static_cast<double>(
      std::ranges::count_if(flight.samples, [](const Sample& s) { return (s.channels & has_rate) != 0; }));
}

// GIVEN a gyro at 500 Hz, and the same at 250 Hz WHEN what is three times as fast as some 130 Hz is read at that THEN every fourth sample of the
// first is read, and of the second every one
TEST(FlightData, AFastSensorIsReadCoarsely) {
  FlightLog log = slow_noisy_positions();
  EXPECT_NEAR(rates_read_coarsely(log), 1000.0, 2.0);
  for (double& t : log.time_s) t *= 2.0;
  EXPECT_NEAR(rates_read_coarsely(log), 4000.0, 2.0);
}

// GIVEN an estimator's rows with everything at 250 Hz, and at 200 Hz WHEN read coarsely THEN every other one of the first is read, and of the second
// every one
TEST(FlightData, AnEstimatorIsReadCoarselyFromALowerRateOn) {
  FlightLog log = slow_noisy_positions();
  for (std::size_t c = 0; c < 6; ++c) log.columns[c].values.assign(log.rows(), 0.0);
  for (std::size_t c = 6; c < 10; ++c) log.columns[c].values.assign(log.rows(), 1000.0);
  const auto rows = static_cast<double>(log.rows());
  for (std::size_t k = 0; k < log.rows(); ++k) log.time_s[k] = 0.004 * static_cast<double>(k);
  EXPECT_NEAR(rates_read_coarsely(log), 0.5 * rows, 2.0);
  for (double& t : log.time_s) t *= 1.25;
  EXPECT_NEAR(rates_read_coarsely(log), rows, 2.0);
}

// GIVEN noisy positions at 500 Hz WHEN read coarsely THEN each is the mean of three, which has less noise
TEST(FlightData, AFastPoseIsReadInMeansOfThree) {
  FlightLog log = slow_noisy_positions();
  const RandomStream random(1, 0, "fast_position_noise");
  std::vector<double>& x = log.columns[0].values;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = 1e-3 * random.normal4(k)[0];
  for (std::size_t k = 0; k < x.size(); ++k) log.time_s[k] = 0.002 * static_cast<double>(k);
  for (const std::size_t c : {1, 2}) log.columns[c].values.assign(x.size(), 0.0);
  ReadingOptions options;
  options.coarse_rate_hz = 130.0;
  double squares = 0.0, count = 0.0;
  for (const Sample& s : prepare_flight(log, read_vehicle("crazyflie", ""), options).samples)
    if (s.channels & has_position) squares += std::pow(s.position_W_m.x(), 2), count += 1.0;
  EXPECT_NEAR(count, static_cast<double>(x.size()) / 4.0, 2.0);
  EXPECT_NEAR(std::sqrt(squares / count), 1e-3 / std::sqrt(3.0), 4e-5);
}

// GIVEN noisy positions between the rows of a fast gyro WHEN smoothed THEN the velocity moves by little from row to row: what moves
// quickly would be most of a column once it is whitened, and make what depends on velocity seem smaller than it is
TEST(FlightData, NoiseOfASlowPositionIsSmooth) {
  const FlightData flight = prepare_flight(slow_noisy_positions(), read_vehicle("crazyflie", ""), {});
  double change = 0.0, square = 0.0;
  for (std::size_t k = 100; k + 100 < flight.motion.size(); ++k) {
    const double interval_s = flight.samples[k].time_s - flight.samples[k - 1].time_s;
    change += (flight.motion[k].velocity_W_mps - flight.motion[k - 1].velocity_W_mps).squaredNorm() / interval_s;
    square += flight.motion[k].velocity_W_mps.squaredNorm();
  }
  // of noise below some 8 Hz, over the mean interval
  EXPECT_LT(change / square, std::pow(2.0 * std::numbers::pi * 8.0, 2) * 0.0034);
}

}  // namespace flight_data_test
}  // namespace gustlab::diagnosis
