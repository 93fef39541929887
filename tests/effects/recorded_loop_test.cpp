// A habit of a recorded loop replaces whatever turns the vehicle, and no controller of ours meets it.
#include "effects/instant.hpp"
#include "gustlab/errors.hpp"
#include "simulation/experiment.hpp"
#include "simulation/make_effects.hpp"
#include "support/experiments.hpp"

namespace gustlab::test {
namespace recorded_loop_test {

EffectSpec loop(std::vector<std::pair<std::string, std::string>> values) {
  EffectSpec spec;
  spec.type = spec.where = "recorded_loop";
  spec.values = std::move(values);
  return spec;
}

Vector3 torque_B_Nm(const Instant& now, const std::vector<EffectSpec>& specs) {
  ForceModel forces(now.vehicle, make_effects(specs));
  forces.prepare(0.002, 1, 1);
  Flow flow = forces.flow(now.state, now.voltage_V);
  RotorSet rotors;
  forces.rotors(now.speed_radps, now.acceleration_radps2, flow, rotors);
  return forces.wrench(flow, rotors, {}).torque_B_Nm;
}

TEST(RecordedLoop, IsTheTorqueOfItsAngularAcceleration) {
  const Instant now;
  const Vector3 torque =
      torque_B_Nm(now, {loop({{"roll", "[-5, 0, 0, 0, 2, 0, 0.5, 0.1]"}, {"yaw", "[0, 0, -3, 0, 0, 0, 0, 0]"}})});
  const Vector3 &rate = now.state.body_rate_B_radps, velocity = now.air_velocity_B();
  const Vector3 acceleration(-5.0 * rate.x() + 2.0 * now.R()(2, 1) + 0.5 * velocity.y() + 0.1, 0.0, -3.0 * rate.z());
  const Matrix3& J = now.vehicle.inertia_B_kgm2;
  EXPECT_LT((torque - (J * acceleration + rate.cross(J * rate))).norm(), 1e-12 * torque.norm());
}

TEST(RecordedLoop, RefusesListsOfAnotherLength) {
  EXPECT_THROW(torque_B_Nm(Instant(), {loop({{"pitch", "[1, 2]"}})}), ConfigError);
}

TEST(RecordedLoop, IsLeftOutWhereAControllerFlies) {
  const Experiment plain = read_text_experiment(small_experiment),
                   with = read_text_experiment(
                       small_experiment + "[[effect]]\ntype = \"recorded_loop\"\nroll = [-5, 0, 0, 0, 0, 0, 0, 0]\n");
  EXPECT_EQ(with.effects.size(), plain.effects.size() + 1);
  EXPECT_EQ(make_flown_effects(with.effects).size(), plain.effects.size());
  EXPECT_EQ(to_hex(plan(with).front().key), to_hex(plan(plain).front().key));
}

}  // namespace recorded_loop_test
}  // namespace gustlab::test
