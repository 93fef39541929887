// The residual that adaptation is fed with, and the force that comes of it.
#include "control/residual.hpp"

#include <gmock/gmock.h>

#include "gustlab/errors.hpp"
#include "support/parameters.hpp"
#include "support/vehicles.hpp"

namespace gustlab {
namespace residual_test {

using ::testing::HasSubstr;

// visit() of a part is as that of a plug-in
struct Part final : Parameterized {
  ResidualAdaptation adaptation;
  void visit(ParameterVisitor& visitor) override { adaptation.visit(visitor); }
};

OffboardSetup setup() {
  OffboardSetup out;
  out.vehicle = test::ring(4, 1.5, 0.25, 0.0);
  out.period_s = 0.02;
  return out;
}

// a steady push that nothing knows of, beside a thrust that is not quite the weight
OffboardInput pushed(const Vector3& push_W_N) {
  OffboardInput in;
  in.position_error_W_m = in.velocity_error_W_mps = Vector3::Zero();
  in.acceleration_command_W_mps2 = {0.3, -0.2, 0.1};
  const Vector3 beyond_weight_W_N(0.2, -0.1, 0.3);
  in.thrust_W_N = setup().vehicle.weight_N() * Vector3::UnitZ() + beyond_weight_W_N;
  in.acceleration_W_mps2 = (push_W_N + beyond_weight_W_N) / 1.5;
  return in;
}

Adaptation::Row one() { return Adaptation::Row::Ones(1, 1); }

TEST(ResidualAdaptation, LearnsASteadyPushAndTakesItAway) {
  Part part;
  test::set_number(part, "leak_radps", 0.0);
  part.adaptation.reset(setup(), Adaptation::Parameters::Zero(1, 3));
  const Vector3 push(1.2, -0.6, 0.9);
  Vector3 force;
  for (int k = 0; k < 2000; ++k) force = part.adaptation.update(pushed(push), one());
  // F_d = m a_cmd + m g − f̂
  const Vector3 wanted = 1.5 * Vector3(0.3, -0.2, 0.1 + 9.81) - push;
  EXPECT_LT((force - wanted).norm(), 1e-3);
  std::array<double, 6> told{};
  part.adaptation.telemetry(told);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(told[static_cast<std::size_t>(i)], push[i], 1e-3);
    EXPECT_NEAR(told[static_cast<std::size_t>(i) + 3], push[i], 1e-9);
  }
}

// first order, at its cut-off, exact for what is held
TEST(ResidualAdaptation, SeesTheResidualThroughItsFilter) {
  Part part;
  test::set_number(part, "filter_hz", 2.0);
  part.adaptation.reset(setup(), Adaptation::Parameters::Zero(1, 3));
  for (int k = 1; k <= 20; ++k) {
    part.adaptation.update(pushed({1.5, 0.0, 0.0}), one());
    std::array<double, 6> told{};
    part.adaptation.telemetry(told);
    EXPECT_NEAR(told[3], 1.5 * (1.0 - std::exp(-2.0 * pi * 2.0 * 0.02 * k)), 1e-12) << k;
  }
}

TEST(ResidualAdaptation, CancelsNoMoreThanItsLimit) {
  Part part;
  test::set_number(part, "limit_weights", 0.1);
  part.adaptation.reset(setup(), Adaptation::Parameters::Zero(1, 3));
  Vector3 force;
  for (int k = 0; k < 2000; ++k) force = part.adaptation.update(pushed({0.0, 5.0, 0.0}), one());
  EXPECT_NEAR(force.y(), 1.5 * -0.2 - 0.1 * setup().vehicle.weight_N(), 1e-9);
}

TEST(ResidualAdaptation, StartsFromWhatItIsGiven) {
  Part part;
  test::set_number(part, "start_covariance", 1e-9);
  test::set_number(part, "growth", 0.0);
  test::set_number(part, "leak_radps", 0.0);
  Adaptation::Parameters start(1, 3);
  start << 0.4, 0.0, -0.2;
  part.adaptation.reset(setup(), start);
  const Vector3 force = part.adaptation.update(pushed(Vector3::Zero()), one());
  EXPECT_LT((force - 1.5 * Vector3(0.3 - 0.4, -0.2, 0.1 + 9.81 + 0.2)).norm(), 1e-6);
}

TEST(ResidualAdaptation, KnowsTwoCovarianceLaws) {
  Part part;
  test::set_text(part, "covariance_law", "printed");
  EXPECT_NO_THROW(part.adaptation.reset(setup(), Adaptation::Parameters::Zero(1, 3)));
  test::set_text(part, "covariance_law", "typed");
  try {
    part.adaptation.reset(setup(), Adaptation::Parameters::Zero(1, 3));
    FAIL() << "accepted";
  } catch (const ParameterError& error) {
    EXPECT_EQ(error.parameter, "covariance_law");
    EXPECT_EQ(error.exit_code(), 2);
    EXPECT_THAT(error.what(), HasSubstr("use corrected or printed"));
  }
}

}  // namespace residual_test
}  // namespace gustlab
