// Layers backwards against finite differences, norms against Eigen's singular values, Adam against its paper.
#include "learning/layers.hpp"

#include <gtest/gtest.h>

#include <Eigen/SVD>

namespace gustlab {
namespace layers_test {

Draws draws(const char* stream) { return Draws(RandomStream(9, 0, stream)); }

Layers some_layers() {
  Draws random = draws("layers");
  Layers layers = random_layers({3, 6, 5, 2}, random);
  for (NetworkWeights::Layer& layer : layers)
    for (double& b : layer.bias) b = 0.3 * random.normal();
  return layers;
}

Eigen::MatrixXd some_batch() {
  Draws random = draws("batch");
  Eigen::MatrixXd batch(4, 3);
  for (double& x : batch.reshaped()) x = random.normal();
  return batch;
}

// a loss whose gradient at the output is known: half the sum of squares
double loss(const Layers& layers, const Eigen::MatrixXd& batch) {
  return 0.5 * forward(layers, batch).back().squaredNorm();
}

TEST(Layers, GoForwardOneSampleARow) {
  const Layers layers = some_layers();
  const Eigen::MatrixXd batch = some_batch(), out = forward(layers, batch).back();
  for (Eigen::Index i = 0; i < batch.rows(); ++i) {
    Eigen::VectorXd x = batch.row(i).transpose();
    x = (layers[0].weight * x + layers[0].bias).cwiseMax(0.0).eval();
    x = (layers[1].weight * x + layers[1].bias).cwiseMax(0.0).eval();
    x = (layers[2].weight * x + layers[2].bias).eval();
    EXPECT_LT((out.row(i).transpose() - x).norm(), 1e-12);
  }
}

TEST(Layers, GoBackwardAsTheirFiniteDifferences) {
  Layers layers = some_layers();
  Eigen::MatrixXd batch = some_batch();
  const Trace trace = forward(layers, batch);
  Layers gradient = zeros_like(layers);
  const Eigen::MatrixXd at_input = backward(layers, trace, trace.back(), gradient);
  constexpr double step = 1e-6;
  const auto slope = [&](double& value) {
    const double before = value;
    value = before + step;
    const double above = loss(layers, batch);
    value = before - step;
    const double below = loss(layers, batch);
    value = before;
    return (above - below) / (2.0 * step);
  };
  for (std::size_t k = 0; k < layers.size(); ++k) {
    for (Eigen::Index i = 0; i < layers[k].weight.size(); ++i)
      EXPECT_NEAR(gradient[k].weight.data()[i], slope(layers[k].weight.data()[i]), 1e-6) << k << ' ' << i;
    for (Eigen::Index i = 0; i < layers[k].bias.size(); ++i)
      EXPECT_NEAR(gradient[k].bias[i], slope(layers[k].bias[i]), 1e-6) << k << ' ' << i;
  }
  for (Eigen::Index i = 0; i < batch.size(); ++i) EXPECT_NEAR(at_input.data()[i], slope(batch.data()[i]), 1e-6) << i;
  // a second pass adds to the first
  Layers twice = gradient;
  backward(layers, trace, trace.back(), twice);
  EXPECT_LT((twice[1].weight - 2.0 * gradient[1].weight).norm(), 1e-12);
}

TEST(Layers, StartWithTheVarianceOfTheirInputs) {
  Draws random = draws("start");
  const Layers layers = random_layers({50, 400, 1}, random);
  EXPECT_NEAR(layers[0].weight.squaredNorm() / 20000.0, 2.0 / 50.0, 0.002);
  EXPECT_EQ(layers[0].bias.norm(), 0.0);
  EXPECT_EQ(layers[1].weight.rows(), 1);
}

TEST(SpectralNorm, IsTheLargestSingularValueAndIsBounded) {
  Layers layers = some_layers();
  layers[1].weight *= 5.0;
  layers[2].weight *= 0.01;
  const Layers before = layers;
  for (const NetworkWeights::Layer& layer : layers)
    EXPECT_NEAR(spectral_norm(layer.weight), Eigen::JacobiSVD<Eigen::MatrixXd>(layer.weight).singularValues()[0],
                1e-10);
  bound_spectral_norm(layers, 1.5);
  for (const NetworkWeights::Layer& layer : layers) EXPECT_LE(spectral_norm(layer.weight), 1.5 + 1e-9);
  EXPECT_LT((layers[1].weight - before[1].weight * (1.5 / spectral_norm(before[1].weight))).norm(), 1e-9);
  EXPECT_EQ(layers[2].weight, before[2].weight);
}

// Kingma & Ba, algorithm 1, one number at a time
TEST(Adam, StepsAsItsPaperSays) {
  Layers layers = {{Eigen::MatrixXd::Constant(1, 1, 0.5), Eigen::VectorXd::Constant(1, -1.0)}};
  Adam adam(layers, 0.01);
  double weight = 0.5, m = 0.0, v = 0.0;
  for (int t = 1; t <= 5; ++t) {
    const double g = 0.3 * t - 0.7;
    Layers gradient = zeros_like(layers);
    gradient[0].weight(0, 0) = g;
    adam.step(layers, gradient);
    m = 0.9 * m + 0.1 * g, v = 0.999 * v + 0.001 * g * g;
    weight -= 0.01 * (m / (1.0 - std::pow(0.9, t))) / (std::sqrt(v / (1.0 - std::pow(0.999, t))) + 1e-8);
    EXPECT_NEAR(layers[0].weight(0, 0), weight, 1e-12) << t;
  }
  EXPECT_EQ(layers[0].bias[0], -1.0);
}

}  // namespace layers_test
}  // namespace gustlab
