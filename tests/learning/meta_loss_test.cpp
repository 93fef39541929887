// The losses of DAIML: their gradients are those that finite differences give, and they mean what they say.
#include "learning/meta_loss.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace gustlab {
namespace meta_loss_test {

Samples random_samples(Eigen::Index count, Draws& draws) {
  Samples samples{Eigen::MatrixXd(count, 4), Eigen::MatrixXd(count, 3)};
  for (double& value : samples.inputs.reshaped()) value = draws.normal();
  for (double& value : samples.residual.reshaped()) value = draws.normal();
  return samples;
}

struct Problem {
  Draws draws{RandomStream(5, 0, "meta_loss_test")};
  Layers features = random_layers({4, 7, 6, 2}, draws);
  Layers discriminator = random_layers({3, 5, 3}, draws);
  MetaBatch batch{random_samples(9, draws), random_samples(14, draws), 1};

  Problem() {
    // a kink at zero would spoil the differences
    for (Layers* layers : {&features, &discriminator})
      for (NetworkWeights::Layer& layer : *layers)
        for (double& bias : layer.bias) bias = 0.3 * draws.normal();
  }
};

// every parameter's central difference against the gradient
void expect_gradient(Layers& layers, const Layers& gradient, const std::function<double()>& loss) {
  const double step = 1e-6;
  const auto check = [&](double& parameter, double slope, const char* what) {
    const double kept = parameter;
    parameter = kept + step;
    const double above = loss();
    parameter = kept - step;
    const double below = loss();
    parameter = kept;
    EXPECT_NEAR((above - below) / (2.0 * step), slope, 1e-7 + 1e-6 * std::abs(slope)) << what;
  };
  for (std::size_t k = 0; k < layers.size(); ++k) {
    for (Eigen::Index i = 0; i < layers[k].weight.size(); ++i)
      check(layers[k].weight(i), gradient[k].weight(i), "weight");
    for (Eigen::Index i = 0; i < layers[k].bias.size(); ++i) check(layers[k].bias(i), gradient[k].bias(i), "bias");
  }
}

void expect_feature_gradient(const MetaLossOptions& options) {
  Problem p;
  Layers gradient = zeros_like(p.features);
  feature_loss(p.features, p.discriminator, p.batch, options, gradient);
  Layers unused = gradient;
  expect_gradient(p.features, gradient,
                  [&] { return feature_loss(p.features, p.discriminator, p.batch, options, unused).total(options); });
}

TEST(MetaLoss, HasTheGradientOfFiniteDifferences) { expect_feature_gradient({.adversary = 0.5, .longest = 1e6}); }

// the coefficients of this problem are longer than 0.2
TEST(MetaLoss, HasItsGradientWhereTheCoefficientsAreShortened) {
  expect_feature_gradient({.adversary = 0.01, .longest = 0.2});
}

TEST(MetaLoss, HasTheDiscriminatorsGradient) {
  Problem p;
  const Eigen::MatrixXd phi = features_at(p.features, p.batch.test.inputs);
  Layers gradient = zeros_like(p.discriminator), unused = gradient;
  discriminator_loss(p.discriminator, phi, 1, gradient);
  expect_gradient(p.discriminator, gradient, [&] { return discriminator_loss(p.discriminator, phi, 1, unused); });
}

TEST(MetaLoss, IsACrossEntropyThatAGuessMakesLogOfTheConditions) {
  Problem p;
  for (NetworkWeights::Layer& layer : p.discriminator) {
    layer.weight.setZero();
    layer.bias.setZero();
  }
  Layers unused = zeros_like(p.discriminator);
  EXPECT_NEAR(discriminator_loss(p.discriminator, features_at(p.features, p.batch.test.inputs), 1, unused),
              std::log(3.0), 1e-12);
}

TEST(MetaLoss, AdaptsToWhatTheFeaturesCanSay) {
  Problem p;
  const Eigen::MatrixXd phi = features_at(p.features, p.batch.adapt.inputs);
  Eigen::MatrixXd truth(3, 3);
  truth << 1.0, -2.0, 0.5, 0.3, 0.1, -0.4, 0.2, 0.0, 1.0;
  EXPECT_NEAR((adapt(phi, phi * truth, {.ridge = 1e-12}) - truth).norm(), 0.0, 1e-6);
  EXPECT_NEAR(adapt(phi, 1e3 * phi * truth, {.longest = 10.0}).norm(), 10.0, 1e-9);
}

TEST(Layers, AreHeldBelowASpectralNorm) {
  Problem p;
  for (NetworkWeights::Layer& layer : p.features) layer.weight *= 5.0;
  const Layers before = p.features;
  bound_spectral_norm(p.features, 2.0);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_GT(spectral_norm(before[k].weight), 2.0);
    EXPECT_NEAR(spectral_norm(p.features[k].weight), 2.0, 1e-9);
    const double scale = p.features[k].weight(0) / before[k].weight(0);
    EXPECT_NEAR((p.features[k].weight - scale * before[k].weight).norm(), 0.0, 1e-12);
  }
  const Layers bounded = p.features;
  bound_spectral_norm(p.features, 2.001);
  EXPECT_EQ(p.features[0].weight, bounded[0].weight);
}

TEST(Layers, AreEvaluatedInTrainingAsInFlight) {
  Problem p;
  NetworkWeights weights{{}, {"a", "b", "c", "d"}, Eigen::VectorXd::Zero(4), Eigen::VectorXd::Ones(4), p.features};
  Network network(weights);
  const Eigen::VectorXd input = p.batch.test.inputs.row(3);
  const Eigen::VectorXd trained = forward(p.features, p.batch.test.inputs).back().row(3);
  EXPECT_NEAR((network.evaluate(std::span<const double>(input.data(), 4)) - trained).norm(), 0.0, 1e-12);
}

}  // namespace meta_loss_test
}  // namespace gustlab
