// Training on conditions that are made up: y = f(x) + c, with the same f everywhere and another c in each condition.
#include "learning/train_daiml.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "control/daiml_input.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {
namespace train_daiml_test {

Condition made_up(const std::string& name, bool held_out, std::uint32_t number, Eigen::Index count = 600) {
  Draws draws(RandomStream(7, number, "made_up"));
  Condition condition{name, held_out, {Eigen::MatrixXd(count, daiml_inputs), Eigen::MatrixXd(count, 3)}};
  const Eigen::RowVector3d wind(draws.normal(), draws.normal(), draws.normal());
  for (Eigen::Index i = 0; i < count; ++i) {
    auto x = condition.samples.inputs.row(i);
    for (double& value : x) value = draws.normal();
    const double drag = x[0] * std::abs(x[0]);
    condition.samples.residual.row(i) = wind + Eigen::RowVector3d(-0.5 * drag, 0.3 * drag + 0.5 * x[4], -0.4 * x[4]);
  }
  return condition;
}

std::vector<Condition> conditions() {
  return {made_up("a", false, 1), made_up("b", false, 2), made_up("c", false, 3), made_up("new", true, 4)};
}

TrainingOptions quick() {
  TrainingOptions options;
  options.epochs = 200;
  return options;
}

double mean(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value / static_cast<double>(values.size());
  return sum;
}

TEST(TrainDaiml, LearnsWhatTheConditionsShare) {
  const Training training = train_daiml(conditions(), quick());
  const std::span<const double> loss = training.prediction;
  EXPECT_LT(mean(loss.last(30)), 0.2 * mean(loss.first(30)));
  // on a condition that it never saw the constant alone leaves all of f
  const ConditionFigures& held_out = training.conditions.back();
  ASSERT_TRUE(held_out.held_out);
  EXPECT_LT(held_out.network_error, 0.4 * held_out.mean_error);
  // x is the same everywhere, so nothing gives a condition away: one in three, and three standard errors of 3 × 600 samples
  EXPECT_NEAR(training.accuracy, training.chance, 0.05);
  EXPECT_NEAR(training.probe_accuracy, training.chance, 0.1);
  EXPECT_NEAR(mean(std::span<const double>(training.confusion).last(30)), std::log(3.0), 0.1);
}

TEST(TrainDaiml, KeepsTheSpectralNormBounded) {
  TrainingOptions options = quick();
  options.spectral_norm = 1.1;
  for (const NetworkWeights::Layer& layer : train_daiml(conditions(), options).network.layers)
    EXPECT_LE(spectral_norm(layer.weight), 1.1 + 1e-9);
}

TEST(TrainDaiml, IsAFunctionOfDataAndSeed) {
  TrainingOptions options = quick();
  options.epochs = 5;
  const std::string once = network_text(train_daiml(conditions(), options).network);
  EXPECT_EQ(network_text(train_daiml(conditions(), options).network), once);
  options.seed = 2;
  EXPECT_NE(network_text(train_daiml(conditions(), options).network), once);
}

// the adversary is what hides a condition that an input gives away
TEST(TrainDaiml, HidesTheConditionFromTheDiscriminator) {
  const auto told = [] {
    std::vector<Condition> all = conditions();
    for (std::size_t c = 0; c < 3; ++c) {
      // input 7 names the condition, and is useful as well
      all[c].samples.inputs.col(7).array() += 4.0 * static_cast<double>(c);
      all[c].samples.residual.col(0) += 0.3 * all[c].samples.inputs.col(7);
    }
    return all;
  }();
  TrainingOptions options = quick();
  options.epochs = 300;
  options.loss.adversary = 0.0;
  const double open = train_daiml(told, options).probe_accuracy;
  options.loss.adversary = 0.3;
  const double hidden = train_daiml(told, options).probe_accuracy;
  EXPECT_GT(open, 0.6) << hidden;
  EXPECT_LT(hidden, open - 0.15);
}

TEST(TrainDaiml, RefusesAConditionThatIsTooShort) {
  std::vector<Condition> all = conditions();
  all.push_back(made_up("short", false, 5, 287));
  EXPECT_THAT(
      [&] { train_daiml(all, quick()); },
      testing::ThrowsMessage<ConfigError>(testing::HasSubstr("condition \"short\": 287 samples (a batch takes 288)")));
}

}  // namespace train_daiml_test
}  // namespace gustlab
