// Incremental inversion against the formulas that it is: the first step of each loop, and the equilibrium that it keeps.
#include "control/indi.hpp"

#include <gtest/gtest.h>

#include "control/attitude.hpp"
#include "support/vehicles.hpp"

namespace gustlab {
namespace indi_test {

constexpr double period_s = 0.002;

VehicleModel vehicle() { return test::ring(4, 1.5, 0.25, 0.0); }

Observation hover(const VehicleModel& model) {
  Observation out;
  out.specific_force_B_mps2.z() = model.gravity_mps2;
  out.rotor_speed_radps.fill(model.hover_speed_radps());
  return out;
}

// rotors without lag and an unfiltered torque: Δu = I K_rate (K_att error), added to what was commanded
TEST(IndiAttitude, CommandsTheTorqueThatTheErrorAsksFor) {
  const VehicleModel model = vehicle();
  IndiOptions options;
  options.filter_hz = 0.0;
  IndiAttitude loop(model, LowLevel::generic, options, period_s);
  loop.reset(hover(model));
  const Mixer mixer(model);
  const Vector3 turn(0.01, -0.02, 0.005);
  const Quaternion wanted(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  const Vector3 torque = model.inertia_B_kgm2 * (options.rate_gain * options.attitude_gain *
                                                 attitude_error_B_rad(Quaternion::Identity(), wanted, 1.0));
  for (int k = 1; k <= 3; ++k) {
    // nothing moves although torque is there: each period adds the same again
    const RotorCommand command = loop.update(hover(model), {model.weight_N(), wanted, Vector3::Zero()});
    EXPECT_LT((mixer.torque_B_Nm(command.speed_radps) - k * torque).norm(), 1e-6 * torque.norm()) << k;
    EXPECT_NEAR(mixer.force_B_N(command.speed_radps).z(), model.weight_N(), 1e-6);
  }
}

// when the body accelerates as it is asked to, nothing is missing
TEST(IndiAttitude, AddsNothingToATorqueThatWorks) {
  const VehicleModel model = vehicle();
  IndiOptions options;
  options.filter_hz = 0.0;
  IndiAttitude loop(model, LowLevel::generic, options, period_s);
  Observation seen = hover(model);
  loop.reset(seen);
  const Mixer mixer(model);
  const Quaternion wanted(Eigen::AngleAxisd(0.01, Vector3::UnitX()));
  RotorCommand command = loop.update(seen, {model.weight_N(), wanted, Vector3::Zero()});
  const Vector3 torque = mixer.torque_B_Nm(command.speed_radps);
  seen.body_rate_B_radps += period_s * (model.inertia_B_kgm2.inverse() * torque);
  command = loop.update(seen, {model.weight_N(), wanted, Vector3::Zero()});
  // the rate that is there already is asked for no more
  const Vector3 less = model.inertia_B_kgm2 * (options.rate_gain * seen.body_rate_B_radps);
  EXPECT_LT((mixer.torque_B_Nm(command.speed_radps) - (torque - less)).norm(), 1e-6 * torque.norm());
}

TEST(IndiOptions, AreScaledToWhatTheRotorsFollowAndNeverUp) {
  const VehicleModel quick = test::ring(4, 1.5, 0.25, 0.0), slow = test::ring(4, 1.5, 0.25, 0.2);
  const IndiOptions base;
  const IndiOptions slowed = scaled(base, slow, LowLevel::generic, period_s);
  EXPECT_LT(slowed.rate_gain, base.rate_gain);
  EXPECT_NEAR(slowed.attitude_gain / base.attitude_gain, slowed.rate_gain / base.rate_gain, 1e-12);
  EXPECT_NEAR(slowed.position_gain / base.position_gain, slowed.rate_gain / base.rate_gain, 1e-12);
  EXPECT_NEAR(slowed.velocity_gain / base.velocity_gain, slowed.rate_gain / base.rate_gain, 1e-12);
  EXPECT_LE(scaled(base, quick, LowLevel::generic, period_s).rate_gain, base.rate_gain);
  EXPECT_EQ(scaled(base, slow, LowLevel::crazyflie, period_s).rate_gain, base.rate_gain);
}

TEST(IndiPosition, HoversWhereItShouldBe) {
  const VehicleModel model = vehicle();
  IndiPosition loop(model, LowLevel::generic, {}, 0.01);
  loop.reset(hover(model));
  for (int k = 0; k < 100; ++k) {
    const ThrustAttitude wanted = loop.update(hover(model), {});
    EXPECT_NEAR(wanted.thrust_N, model.weight_N(), 1e-9);
    EXPECT_LT(wanted.attitude_WB.angularDistance(Quaternion::Identity()), 1e-9);
  }
}

// a = K_v K_p Δp: from level, pitch a/g for x, roll −a/g for y, and m a of thrust for z
TEST(IndiPosition, TiltsAndLiftsByTheInverseOfGravityAndMass) {
  const VehicleModel model = vehicle();
  IndiOptions options;
  options.filter_hz = 0.0;
  Reference reference;
  reference.position_W_m = {0.02, -0.03, 0.04};
  IndiPosition loop(model, LowLevel::generic, options, 0.01);
  loop.reset(hover(model));
  const ThrustAttitude wanted = loop.update(hover(model), reference);
  const Vector3 acceleration = options.velocity_gain * options.position_gain * reference.position_W_m;
  const EulerAngles angles = euler_angles(wanted.attitude_WB);
  EXPECT_NEAR(angles.pitch_rad, acceleration.x() / 9.81, 1e-4);
  EXPECT_NEAR(angles.roll_rad, -acceleration.y() / 9.81, 1e-4);
  EXPECT_NEAR(wanted.thrust_N, model.mass_kg * (9.81 + acceleration.z()), 1e-9);
}

TEST(IndiPosition, TiltsNoFurtherThanItsLimit) {
  const VehicleModel model = vehicle();
  const IndiOptions options;
  IndiPosition loop(model, LowLevel::generic, options, 0.01);
  loop.reset(hover(model));
  Reference reference;
  reference.position_W_m = {50.0, 0.0, 0.0};
  const EulerAngles angles = euler_angles(loop.update(hover(model), reference).attitude_WB);
  EXPECT_NEAR(angles.pitch_rad, options.tilt_limit_rad, 1e-6);
}

// flatness form: force = what thrust gives + m (a_wanted − a_felt)
TEST(IndiForce, AddsToTheThrustWhatIsMissing) {
  const VehicleModel model = vehicle();
  IndiOptions options;
  options.filter_hz = 0.0;
  constexpr double bandwidth = 2.0, damping = 0.7;
  IndiForce loop(model, options, bandwidth, damping, period_s);
  Observation seen = hover(model);
  loop.reset(seen);
  seen.specific_force_B_mps2 += Vector3(0.3, 0.0, -0.5);  // a push that the rotors do not make
  seen.position_W_m = {0.05, 0.0, 0.0};
  seen.velocity_W_mps = {0.0, -0.1, 0.0};
  Reference reference;
  reference.acceleration_W_mps2 = {0.0, 0.0, 0.2};
  const ThrustAttitude wanted = loop.update(seen, reference);
  const Vector3 acceleration(-bandwidth * bandwidth * 0.05 - 0.3, 2.0 * damping * bandwidth * 0.1, 0.2 + 0.5);
  const Vector3 force = model.weight_N() * Vector3::UnitZ() + model.mass_kg * acceleration;
  EXPECT_NEAR(wanted.thrust_N, force.z(), 1e-6);
  EXPECT_LT((wanted.attitude_WB * Vector3::UnitZ() - force.normalized()).norm(), 1e-9);
}

}  // namespace indi_test
}  // namespace gustlab
