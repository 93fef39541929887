// Closed forms of the effects that change thrust, reaction torque and axes, and of the body effects.
#include <cmath>

#include "effects/instant.hpp"

namespace gustlab::test {
namespace rotor_test {

// thrust and reaction torque of each rotor, relative to the nominal
struct Ratio {
  RotorArray thrust{}, reaction{};
};
Ratio ratio(const Instant& now, const std::vector<Wanted>& wanted) {
  const RotorSet rotors = now.evaluate(wanted).rotors;
  Ratio result;
  for (std::size_t i = 0; i < 4; ++i) {
    result.thrust[i] = rotors.thrust_N[i] / now.nominal_thrust_N(i);
    result.reaction[i] = rotors.reaction_Nm[i] / (now.vehicle.rotors[i].torque_ratio_m * now.nominal_thrust_N(i));
  }
  return result;
}

TEST(NominalRotors, PushAlongZAndReactAgainstTheirSpin) {
  const Instant now;
  const Evaluated out = now.evaluate({});
  Vector3 torque = Vector3::Zero();
  double thrust = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double f = now.nominal_thrust_N(i);
    thrust += f;
    torque += now.hub_B(i).cross(Vector3(0, 0, f));
    torque.z() -= now.vehicle.rotors[i].direction * now.vehicle.rotors[i].torque_ratio_m * f;
  }
  expect_near(out.wrench.force_B_N, {0, 0, thrust});
  expect_near(out.wrench.torque_B_Nm, torque);
}

TEST(AxialInflow, TakesThrustFromClimbingHubsAlone) {
  const Instant now;
  const RotorSet rotors = now.evaluate({{"axial_inflow", {{"at_hover", 0.012}}}}).rotors;
  for (std::size_t i = 0; i < 4; ++i) {
    const double lost = 0.012 / (4 * now.vehicle.hover_speed_radps()) * now.speed_radps[i] * now.hub_velocity_B(i).z();
    EXPECT_NEAR(rotors.thrust_N[i], now.nominal_thrust_N(i) - lost, 1e-12);
    EXPECT_EQ(rotors.reaction_Nm[i], now.vehicle.rotors[i].torque_ratio_m * now.nominal_thrust_N(i));
  }
}

TEST(AxialInflow, DampsRollAndPitch) {
  Instant still, rolling;
  still.state.body_rate_B_radps.setZero();
  rolling.state.body_rate_B_radps = {5.0, -4.0, 0.0};
  const std::vector<Wanted> inflow = {{"axial_inflow", {{"at_hover", 0.012}}}};
  const Vector3 change = rolling.evaluate(inflow).wrench.torque_B_Nm - still.evaluate(inflow).wrench.torque_B_Nm;
  EXPECT_LT(change.x(), 0.0);
  EXPECT_GT(change.y(), 0.0);
}

TEST(TranslationalLift, AddsTheSquareOfTheInPlaneSpeed) {
  const Instant now;
  const RotorSet rotors = now.evaluate({{"translational_lift", {{"coefficient", 3e-4}}}}).rotors;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3 v = now.hub_velocity_B(i);
    EXPECT_NEAR(rotors.thrust_N[i], now.nominal_thrust_N(i) + 3e-4 * (v.x() * v.x() + v.y() * v.y()), 1e-12);
    EXPECT_EQ(rotors.reaction_Nm[i], now.vehicle.rotors[i].torque_ratio_m * now.nominal_thrust_N(i));
  }
}

TEST(GroundEffect, GrowsWithEachRotorsOwnHeight) {
  const Instant now;
  const Ratio r = ratio(now, {{"ground_effect", {{"strength", 6.0}}}});
  for (std::size_t i = 0; i < 4; ++i) {
    const double height = (now.state.position_W_m + now.R() * now.vehicle.rotors[i].position_B_m).z();
    EXPECT_NEAR(r.thrust[i], 1.0 + 6.0 * std::pow(now.vehicle.rotor_radius_m / (4 * height), 2), 1e-12);
    EXPECT_EQ(r.reaction[i], 1.0);
  }
}

TEST(GroundEffect, StopsGrowingBelowOneRadiusAndNeedsAGround) {
  Instant low;
  low.state.position_W_m.z() = -0.02;
  low.state.attitude_WB.setIdentity();
  EXPECT_DOUBLE_EQ(ratio(low, {{"ground_effect", {{"strength", 6.0}}}}).thrust[0], 1.0 + 6.0 / 16.0);
  low.vehicle.environment.ground_z_m.reset();
  EXPECT_EQ(ratio(low, {{"ground_effect", {{"strength", 6.0}}}}).thrust[0], 1.0);
}

TEST(CeilingEffect, GrowsWithEachRotorsOwnDistanceBelowIt) {
  const Instant now;
  const Ratio r = ratio(now, {{"ceiling_effect", {{"strength", 6.0}}}});
  for (std::size_t i = 0; i < 4; ++i) {
    const double distance = 0.2 - (now.state.position_W_m + now.R() * now.vehicle.rotors[i].position_B_m).z();
    EXPECT_NEAR(r.thrust[i], 1.0 + 6.0 * std::pow(now.vehicle.rotor_radius_m / (4 * distance), 2), 1e-12);
    EXPECT_EQ(r.reaction[i], 1.0);
  }
}

TEST(ThrustScale, ScalesThrustAndReactionOfAll) {
  const Ratio r = ratio(Instant{}, {{"thrust_scale", {{"delta", -0.1}}}});
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(r.thrust[i], 0.9);
    EXPECT_DOUBLE_EQ(r.reaction[i], 0.9);
  }
}

TEST(RotorLoss, TakesThrustAndReactionOfOneRotor) {
  const Ratio r = ratio(Instant{}, {{"rotor_loss", {{"rotor", 3}, {"loss", 0.2}}}});
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(r.thrust[i], i == 2 ? 0.8 : 1.0);
    EXPECT_DOUBLE_EQ(r.reaction[i], i == 2 ? 0.8 : 1.0);
  }
}

TEST(RotorLoss, TwoRotorsMayLose) {
  const Ratio r =
      ratio(Instant{}, {{"rotor_loss", {{"rotor", 3}, {"loss", 0.2}}}, {"rotor_loss", {{"rotor", 1}, {"loss", 0.1}}}});
  EXPECT_DOUBLE_EQ(r.thrust[0], 0.9);
  EXPECT_DOUBLE_EQ(r.thrust[2], 0.8);
}

TEST(RotorLoss, RefusesARotorThatIsNotThere) {
  EXPECT_THROW(ratio(Instant{}, {{"rotor_loss", {{"rotor", 5}, {"loss", 0.2}}}}), std::runtime_error);
}

TEST(ThrustCurve, IsRightAtHoverAndOffElsewhere) {
  Instant now;
  now.speed_radps[0] = now.vehicle.hover_speed_radps();
  const Ratio r = ratio(now, {{"thrust_curve", {{"curvature", 0.2}}}});
  for (std::size_t i = 0; i < 4; ++i) {
    const double excess = now.nominal_thrust_N(i) / (now.vehicle.mass_kg * 9.81 / 4) - 1.0;
    EXPECT_NEAR(r.thrust[i], 1.0 + 0.2 * excess, 1e-12);
    EXPECT_NEAR(r.reaction[i], 1.0 + 0.2 * excess, 1e-12);
  }
  EXPECT_NEAR(r.thrust[0], 1.0, 1e-12);
}

TEST(BatterySag, FollowsTheVoltageWhereItIsKnownAndTimeWhereNot) {
  Instant now;
  const std::vector<Wanted> sag = {{"battery_sag", {{"exponent", 1.5}, {"rate", 0.004}}}};
  EXPECT_NEAR(ratio(now, sag).thrust[0], std::pow(3.5 / 3.8, 1.5), 1e-12);
  EXPECT_NEAR(ratio(now, sag).reaction[1], std::pow(3.5 / 3.8, 1.5), 1e-12);
  now.voltage_V = 0.0;
  EXPECT_NEAR(ratio(now, sag).thrust[0], 1.0 - 0.004 * 7.0, 1e-12);
  now.voltage_V = 3.5;
  now.vehicle.nominal_voltage_V = 0.0;
  EXPECT_NEAR(ratio(now, sag).thrust[0], 1.0 - 0.004 * 7.0, 1e-12);
}

TEST(YawTorqueRatio, ScalesTheReactionAlone) {
  const Ratio r = ratio(Instant{}, {{"yaw_torque_ratio", {{"delta", 0.3}}}});
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(r.thrust[i], 1.0);
    EXPECT_DOUBLE_EQ(r.reaction[i], 1.3);
  }
}

TEST(RotorTilt, TurnsThrustAndReaction) {
  const Instant now;
  const Vector3 axis(0.02, -0.03, 1.0);
  Vector3 force = Vector3::Zero(), torque = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const Rotor& rotor = now.vehicle.rotors[i];
    const Vector3 f = now.nominal_thrust_N(i) * axis;
    force += f;
    torque += now.hub_B(i).cross(f) - rotor.direction * rotor.torque_ratio_m * f;
  }
  const Wrench wrench = now.evaluate({{"rotor_tilt", {{"x", 0.02}, {"y", -0.03}}}}).wrench;
  expect_near(wrench.force_B_N, force);
  expect_near(wrench.torque_B_Nm, torque);
}

// scale and loss → inflow and lift → ground → tilt, whatever the order in which they are listed
TEST(OrderOfApplication, IsThatOfTheCatalogue) {
  const Instant now;
  std::vector<Wanted> wanted = {{"rotor_tilt", {{"x", 0.02}}},           {"ground_effect", {{"strength", 6.0}}},
                                {"axial_inflow", {{"at_hover", 0.012}}}, {"thrust_scale", {{"delta", 0.1}}},
                                {"yaw_torque_ratio", {{"delta", 0.3}}},  {"thrust_curve", {{"curvature", 0.2}}}};
  const Evaluated out = now.evaluate(wanted);
  for (std::size_t i = 0; i < 4; ++i) {
    const double nominal = now.nominal_thrust_N(i);
    const double scaled = nominal * (1 + 0.2 * (nominal / now.vehicle.hover_thrust_N() - 1)) * 1.1;
    const double inflow =
        0.012 / (4 * now.vehicle.hover_speed_radps()) * now.speed_radps[i] * now.hub_velocity_B(i).z();
    const double height = (now.state.position_W_m + now.R() * now.vehicle.rotors[i].position_B_m).z();
    const double ground = 1.0 + 6.0 * std::pow(now.vehicle.rotor_radius_m / (4 * height), 2);
    EXPECT_NEAR(out.rotors.thrust_N[i], (scaled - inflow) * ground, 1e-12);
    EXPECT_NEAR(out.rotors.reaction_Nm[i], now.vehicle.rotors[i].torque_ratio_m * scaled * 1.3, 1e-15);
    expect_near(out.rotors.axis_B[i], {0.02, 0.0, 1.0});
  }
  std::reverse(wanted.begin(), wanted.end());
  const Evaluated reversed = now.evaluate(wanted);
  EXPECT_EQ(out.wrench.force_B_N, reversed.wrench.force_B_N);
  EXPECT_EQ(out.wrench.torque_B_Nm, reversed.wrench.torque_B_Nm);
}

TEST(Mass, ChangesWeightAndNotInertia) {
  const Instant now;
  const VehicleModel vehicle = now.evaluate({{"mass", {{"delta", -0.1}}}}).vehicle;
  EXPECT_DOUBLE_EQ(vehicle.mass_kg, 0.9 * now.vehicle.mass_kg);
  EXPECT_EQ(vehicle.inertia_B_kgm2, now.vehicle.inertia_B_kgm2);
}

// drag, inflow and thrust curve are said at hover: of the vehicle file, whatever it carries
TEST(Mass, ChangesNoRotor) {
  const Instant now;
  const std::vector<Wanted> rotors = {{"rotor_drag", {{"at_hover", 0.02}}},
                                      {"axial_inflow", {{"at_hover", 0.01}}},
                                      {"thrust_curve", {{"curvature", 0.2}}}};
  std::vector<Wanted> loaded = rotors;
  loaded.push_back({"mass", {{"delta", 0.3}}});
  const Evaluated light = now.evaluate(rotors), heavy = now.evaluate(loaded);
  EXPECT_EQ(light.wrench.force_B_N, heavy.wrench.force_B_N);
  EXPECT_EQ(light.wrench.torque_B_Nm, heavy.wrench.torque_B_Nm);
}

TEST(CenterOfMass, MovesArmsAndTheLoggedPoint) {
  const Instant now;
  const Evaluated out = now.evaluate({{"center_of_mass", {{"x", 0.002}, {"y", -0.001}, {"z", 0.003}}}});
  const Vector3 moved = now.vehicle.center_of_mass_B_m + Vector3(0.002, -0.001, 0.003);
  expect_near(out.vehicle.center_of_mass_B_m, moved);
  for (std::size_t i = 0; i < 4; ++i) expect_near(out.rotors.hub_B_m[i], now.vehicle.rotors[i].position_B_m - moved);
  // v_log = v_com − R (ω × r_c)
  expect_near(out.flow.velocity_W_mps, now.state.velocity_W_mps + now.R() * now.state.body_rate_B_radps.cross(moved));
  // weight forward of the rotors turns the nose down: thrust pushes up behind it
  Instant level;
  level.vehicle.center_of_mass_B_m.setZero();
  level.speed_radps.fill(2000);
  EXPECT_GT(level.evaluate({{"center_of_mass", {{"x", 0.002}}}}).wrench.torque_B_Nm.y(), 0.0);
}

TEST(Inertia, ScalesEachAxisAndKeepsCorrelation) {
  Instant now;
  now.vehicle.inertia_B_kgm2(0, 1) = now.vehicle.inertia_B_kgm2(1, 0) = 2e-6;
  const Matrix3 before = now.vehicle.inertia_B_kgm2;
  const Matrix3 after =
      now.evaluate({{"inertia", {{"delta_x", 0.2}, {"delta_y", -0.1}, {"delta_z", 0.3}}}}).vehicle.inertia_B_kgm2;
  EXPECT_DOUBLE_EQ(after(0, 0), 1.2 * before(0, 0));
  EXPECT_DOUBLE_EQ(after(1, 1), 0.9 * before(1, 1));
  EXPECT_DOUBLE_EQ(after(2, 2), 1.3 * before(2, 2));
  EXPECT_DOUBLE_EQ(after(0, 1) / std::sqrt(after(0, 0) * after(1, 1)),
                   before(0, 1) / std::sqrt(before(0, 0) * before(1, 1)));
  EXPECT_EQ(after(0, 1), after(1, 0));
}

}  // namespace rotor_test
}  // namespace gustlab::test
