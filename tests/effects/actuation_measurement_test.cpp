// Closed forms of the command's way to the rotors and of the sensors.
#include <cmath>

#include "effects/instant.hpp"

namespace gustlab::test {
namespace actuation_measurement_test {

// a command that steps from 1000 to 2000 rad/s at t = 0
struct StepPast final : Actuation::Past {
  double now_s = 0.0, step_s = 0.002;
  void command(double age_s, RotorArray& speed) const override {
    const double from = now_s - age_s, share = std::clamp((from + step_s) / step_s, 0.0, 1.0);
    speed.fill(1000.0 + 1000.0 * share);
  }
};

Actuation actuate(const std::vector<Wanted>& wanted, Actuation actuation, bool speed_is_measured = false) {
  ForceModel forces(small_quadrotor(), make_effect_list(wanted));
  forces.set_speed_is_measured(speed_is_measured);
  forces.prepare(0.002, 1, 1);
  if (actuation.step_s == 0.0) actuation.step_s = 0.002;
  forces.actuate(actuation);
  return actuation;
}

Actuation asked(double command_radps, double start_radps) {
  Actuation actuation;
  actuation.command_radps.fill(command_radps);
  actuation.start_speed_radps.fill(start_radps);
  return actuation;
}

TEST(NoEffect, RotorsObeyAtOnceWithinTheirRange) {
  EXPECT_EQ(actuate({}, asked(1500, 1000)).end_speed_radps[0], 1500.0);
  EXPECT_EQ(actuate({}, asked(9999, 1000)).mean_speed_radps[0], 3052.0);
  EXPECT_EQ(actuate({}, asked(-5, 1000)).mean_speed_radps[0], 0.0);
}

TEST(MotorLag, IsTheExactFirstOrderResponse) {
  const Actuation out =
      actuate({{"motor_lag", {{"time_constant", 0.05}, {"time_constant_down", 0.08}}}}, asked(2000, 1000));
  EXPECT_NEAR(out.end_speed_radps[0], 2000 - 1000 * std::exp(-0.002 / 0.05), 1e-9);
  EXPECT_NEAR(out.mean_speed_radps[0], 2000 - 1000 * (1 - std::exp(-0.002 / 0.05)) * 0.05 / 0.002, 1e-9);
  const Actuation down =
      actuate({{"motor_lag", {{"time_constant", 0.05}, {"time_constant_down", 0.08}}}}, asked(1000, 2000));
  EXPECT_NEAR(down.end_speed_radps[0], 1000 + 1000 * std::exp(-0.002 / 0.08), 1e-9);
}

TEST(MotorLag, IsExactOverAnyOtherStep) {
  Actuation actuation = asked(2000, 1000);
  actuation.step_s = 0.0035;
  const Actuation out = actuate({{"motor_lag", {{"time_constant", 0.05}}}}, actuation);
  EXPECT_NEAR(out.end_speed_radps[0], 2000 - 1000 * std::exp(-0.0035 / 0.05), 1e-9);
  EXPECT_NEAR(out.mean_speed_radps[0], 2000 - 1000 * (1 - std::exp(-0.0035 / 0.05)) * 0.05 / 0.0035, 1e-9);
}

TEST(MotorLag, OneTimeConstantServesBothWays) {
  const Actuation down = actuate({{"motor_lag", {{"time_constant", 0.05}}}}, asked(1000, 2000));
  EXPECT_NEAR(down.end_speed_radps[0], 1000 + 1000 * std::exp(-0.002 / 0.05), 1e-9);
}

TEST(ActuationDelay, AsksForThePast) {
  StepPast past;
  Actuation actuation = asked(2000, 1000);
  actuation.past = &past;
  for (const auto& [now_s, expected] : {std::pair{0.004, 1000.0}, {0.009, 1500.0}, {0.012, 2000.0}}) {
    past.now_s = now_s;
    const Actuation out = actuate({{"actuation_delay", {{"delay", 0.010}}}}, actuation);
    EXPECT_NEAR(out.command_radps[0], expected, 1e-9);
    EXPECT_NEAR(out.end_speed_radps[0], expected, 1e-9);
    EXPECT_NEAR(out.mean_speed_radps[0], expected, 1e-9);
  }
}

TEST(ActuationDelay, ComesBeforeTheLag) {
  StepPast past;
  past.now_s = 0.012;
  Actuation actuation = asked(500, 1000);
  actuation.past = &past;
  const Actuation out =
      actuate({{"motor_lag", {{"time_constant", 0.05}}}, {"actuation_delay", {{"delay", 0.010}}}}, actuation);
  EXPECT_NEAR(out.end_speed_radps[0], 2000 - 1000 * std::exp(-0.002 / 0.05), 1e-9);
}

TEST(Saturation, ClipsAboveAndStopsBelow) {
  const std::vector<Wanted> limits = {{"saturation", {{"max_speed", 2500}, {"dead_zone", 0.2}}}};
  EXPECT_EQ(actuate(limits, asked(2800, 0)).mean_speed_radps[0], 2500.0);
  EXPECT_EQ(actuate(limits, asked(501, 0)).mean_speed_radps[0], 501.0);
  EXPECT_EQ(actuate(limits, asked(499, 0)).mean_speed_radps[0], 0.0);
  EXPECT_EQ(actuate({{"saturation", {{"dead_zone", 0.2}}}}, asked(600, 0)).mean_speed_radps[0], 0.0);
}

TEST(BatterySag, SlowsTheRotorsWhereTheirSpeedIsMeasured) {
  Actuation actuation = asked(2000, 0);
  actuation.voltage_V = 3.5;
  const std::vector<Wanted> sag = {{"battery_sag", {{"exponent", 1.5}}}};
  EXPECT_EQ(actuate(sag, actuation).end_speed_radps[0], 2000.0);
  EXPECT_NEAR(actuate(sag, actuation, true).end_speed_radps[0], 2000.0 * std::pow(3.5 / 3.8, 0.75), 1e-9);
}

// what the sensors of a list of effects make of one instant
struct Truth final : MeasurementContext::Past {
  VehicleState at(double time_s) const override {
    VehicleState state = Instant{}.state;
    state.position_W_m += (time_s - 7.0) * state.velocity_W_mps;
    state.velocity_W_mps *= time_s / 7.0;
    state.attitude_WB = state.attitude_WB * Quaternion(Eigen::AngleAxisd(time_s - 7.0, Vector3::UnitX()));
    return state;
  }
};

Measured measure(const std::vector<Wanted>& wanted, std::int64_t tick = 0, std::uint64_t seed = 1) {
  ForceModel forces(small_quadrotor(), make_effect_list(wanted));
  forces.prepare(0.002, seed, 1);
  const VehicleState state = Instant{}.state;
  const Truth truth;
  MeasurementContext context;
  context.time_s = 7.0;
  context.tick = tick;
  context.angular_acceleration_B_radps2 = {10.0, -20.0, 30.0};
  context.past = &truth;
  Measured measured{
      state.position_W_m, state.velocity_W_mps, state.attitude_WB, state.body_rate_B_radps, {0.1, 0.2, 9.8}};
  forces.measure(context, measured);
  return measured;
}

Vector3 turn_between(const Quaternion& from, const Quaternion& to) {
  const Eigen::AngleAxisd turn(from.conjugate() * to);
  return turn.angle() * turn.axis();
}

TEST(AttitudeOffset, TurnsTheLoggedFrameOnTheRight) {
  const Quaternion truth = Instant{}.state.attitude_WB;
  expect_near(turn_between(truth, measure({{"attitude_offset", {{"x", 0.02}, {"y", -0.03}}}}).attitude_WB),
              {0.02, -0.03, 0.0}, 1e-7);
  expect_near(turn_between(truth, measure({{"yaw_offset", {{"z", 0.05}}}}).attitude_WB), {0.0, 0.0, 0.05}, 1e-7);
}

TEST(PoseDelay, MakesPoseAndVelocityOldAndLeavesInertialData) {
  const Instant now;
  const Measured late = measure({{"pose_delay", {{"delay", 0.02}}}});
  expect_near(late.position_W_m, now.state.position_W_m - 0.02 * now.state.velocity_W_mps);
  expect_near(late.velocity_W_mps, now.state.velocity_W_mps * (6.98 / 7.0));
  expect_near(turn_between(now.state.attitude_WB, late.attitude_WB), {-0.02, 0.0, 0.0}, 1e-7);
  EXPECT_EQ(late.body_rate_B_radps, now.state.body_rate_B_radps);
  EXPECT_EQ(late.specific_force_B_mps2, Vector3(0.1, 0.2, 9.8));
}

TEST(PoseDelay, ComesBeforeTheOffsetOfTheLoggedFrame) {
  const Measured both = measure({{"attitude_offset", {{"y", 0.1}}}, {"pose_delay", {{"delay", 0.02}}}});
  const Measured late = measure({{"pose_delay", {{"delay", 0.02}}}});
  expect_near(turn_between(late.attitude_WB, both.attitude_WB), {0.0, 0.1, 0.0}, 1e-7);
}

TEST(ImuLever, AddsAngularAndCentripetalAcceleration) {
  const Vector3 lever(0.01, -0.02, 0.005), rate = Instant{}.state.body_rate_B_radps, angular(10.0, -20.0, 30.0);
  const Measured out = measure({{"imu_lever", {{"x", 0.01}, {"y", -0.02}, {"z", 0.005}}}});
  expect_near(out.specific_force_B_mps2, Vector3(0.1, 0.2, 9.8) + angular.cross(lever) + rate.cross(rate.cross(lever)));
  EXPECT_EQ(out.body_rate_B_radps, rate);
}

TEST(GyroScale, ScalesTheReadingAlone) {
  const Measured out = measure({{"gyro_scale", {{"delta", 0.02}}}});
  expect_near(out.body_rate_B_radps, 1.02 * Instant{}.state.body_rate_B_radps);
  // the lever feels the true rate
  const Measured both = measure({{"gyro_scale", {{"delta", 0.02}}}, {"imu_lever", {{"x", 0.01}}}});
  EXPECT_EQ(both.specific_force_B_mps2, measure({{"imu_lever", {{"x", 0.01}}}}).specific_force_B_mps2);
}

TEST(MeasurementNoise, HasTheDeviationsAndBiasesAsked) {
  const Instant now;
  constexpr int n = 4000;
  Vector3 sum[5], squares[5];
  for (int c = 0; c < 5; ++c) sum[c] = squares[c] = Vector3::Zero();
  const std::vector<Wanted> noise = {{"measurement_noise",
                                      {{"position_sd", 0.001},
                                       {"velocity_sd", 0.02},
                                       {"attitude_sd", 0.005},
                                       {"rate_sd", 0.05},
                                       {"accelerometer_sd", 0.3},
                                       {"rate_bias.y", 0.5},
                                       {"accelerometer_bias.z", -2.0}}}};
  constexpr double deviation[5] = {0.001, 0.02, 0.005, 0.05, 0.3};
  for (int k = 0; k < n; ++k) {
    const Measured m = measure(noise, k);
    const Vector3 error[5] = {m.position_W_m - now.state.position_W_m, m.velocity_W_mps - now.state.velocity_W_mps,
                              turn_between(now.state.attitude_WB, m.attitude_WB),
                              m.body_rate_B_radps - now.state.body_rate_B_radps - Vector3(0, 0.5, 0),
                              m.specific_force_B_mps2 - Vector3(0.1, 0.2, 7.8)};
    for (int c = 0; c < 5; ++c) sum[c] += error[c] / n, squares[c] += error[c].cwiseAbs2() / n;
  }
  // five standard errors of mean and of standard deviation
  for (int c = 0; c < 5; ++c)
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(sum[c][a], 0.0, 5 * deviation[c] / std::sqrt(n)) << c << a;
      EXPECT_NEAR(std::sqrt(squares[c][a]), deviation[c], 5 * deviation[c] / std::sqrt(2.0 * n)) << c << a;
    }
}

TEST(MeasurementNoise, IsAFunctionOfSeedAndTickAndSensorsAreIndependent) {
  const std::vector<Wanted> position = {{"measurement_noise", {{"position_sd", 0.001}}}};
  const std::vector<Wanted> both = {{"measurement_noise", {{"position_sd", 0.001}, {"rate_sd", 0.05}}}};
  EXPECT_EQ(measure(position, 5).position_W_m, measure(both, 5).position_W_m);
  EXPECT_NE(measure(position, 5).position_W_m, measure(position, 6).position_W_m);
  EXPECT_NE(measure(position, 5).position_W_m, measure(position, 5, 2).position_W_m);
}

}  // namespace actuation_measurement_test
}  // namespace gustlab::test
