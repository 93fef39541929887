// A force in world or body axes and a torque, as sparse sums of terms of the state.
#include "effects/instant.hpp"
#include "gustlab/errors.hpp"
#include "simulation/make_effects.hpp"

namespace gustlab::test {
namespace sindy_residual_test {

Wrench added(const Instant& now, std::vector<std::pair<std::string, std::string>> values) {
  EffectSpec spec;
  spec.type = spec.where = "sindy_residual";
  spec.values = std::move(values);
  const auto at = [&](const std::vector<EffectSpec>& specs) {
    ForceModel forces(now.vehicle, make_effects(specs));
    forces.prepare(0.002, 1, 1);
    Flow flow = forces.flow(now.state, now.voltage_V);
    RotorSet rotors;
    forces.rotors(now.speed_radps, now.acceleration_radps2, flow, rotors);
    return forces.wrench(flow, rotors, {});
  };
  const Wrench with = at({spec}), without = at({});
  return {with.force_B_N - without.force_B_N, with.torque_B_Nm - without.torque_B_Nm};
}

TEST(SindyResidual, PushesAlongTheAxesOfItsFrame) {
  const Instant now;
  const Wrench world =
      added(now, {{"terms", "[\"1\", \"px\"]"}, {"fx", "[0.01, 0.1]"}, {"fy", "[0, 0]"}, {"fz", "[0.02, 0]"}});
  EXPECT_LT((now.R() * world.force_B_N - Vector3(0.01 + 0.1 * 0.4, 0.0, 0.02)).norm(), 1e-12);
  const Wrench body = added(now, {{"frame", "\"body\""},
                                  {"terms", "[\"1\", \"px\"]"},
                                  {"fx", "[0.01, 0.1]"},
                                  {"fy", "[0, 0]"},
                                  {"fz", "[0.02, 0]"}});
  EXPECT_LT((body.force_B_N - Vector3(0.01 + 0.1 * 0.4, 0.0, 0.02)).norm(), 1e-12);
  EXPECT_EQ(body.torque_B_Nm, Vector3::Zero());
}

TEST(SindyResidual, TurnsAboutBodyAxes) {
  const Instant now;
  const Wrench turn =
      added(now, {{"terms", "[\"pz\"]"}, {"fx", "[0]"}, {"fy", "[0]"}, {"fz", "[0]"}, {"ty", "[0.001]"}});
  EXPECT_LT((turn.torque_B_Nm - Vector3(0.0, 0.001 * 0.06, 0.0)).norm(), 1e-15);
  EXPECT_EQ(turn.force_B_N, Vector3::Zero());
}

TEST(SindyResidual, RefusesAnUnknownFrameAndListsOfAnotherLength) {
  const Instant now;
  EXPECT_THROW(added(now, {{"frame", "\"moon\""}}), ConfigError);
  EXPECT_THROW(added(now, {{"terms", "[\"pz\"]"}, {"fx", "[0]"}, {"fy", "[0]"}, {"fz", "[0]"}, {"tx", "[1, 2]"}}),
               ConfigError);
}

}  // namespace sindy_residual_test
}  // namespace gustlab::test
