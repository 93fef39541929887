#include "learning/layers.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace gustlab {

Layers random_layers(std::initializer_list<Eigen::Index> widths, Draws& draws) {
  Layers layers;
  for (auto width = widths.begin() + 1; width != widths.end(); ++width) {
    const Eigen::Index inputs = width[-1];
    NetworkWeights::Layer layer{Eigen::MatrixXd(*width, inputs), Eigen::VectorXd::Zero(*width)};
    const double sd = std::sqrt(2.0 / static_cast<double>(inputs));
    for (double& weight : layer.weight.reshaped()) weight = sd * draws.normal();
    layers.push_back(std::move(layer));
  }
  return layers;
}

Layers zeros_like(const Layers& layers) {
  Layers zeros = layers;
  for (NetworkWeights::Layer& layer : zeros) {
    layer.weight.setZero();
    layer.bias.setZero();
  }
  return zeros;
}

Trace forward(const Layers& layers, const Eigen::MatrixXd& input) {
  Trace trace{input};
  for (std::size_t k = 0; k < layers.size(); ++k) {
    Eigen::MatrixXd out = trace.back() * layers[k].weight.transpose();
    out.rowwise() += layers[k].bias.transpose();
    if (k + 1 < layers.size()) out = out.cwiseMax(0.0);
    trace.push_back(std::move(out));
  }
  return trace;
}

Eigen::MatrixXd backward(const Layers& layers, const Trace& trace, const Eigen::MatrixXd& at_output, Layers& gradient) {
  Eigen::MatrixXd at = at_output;
  for (std::size_t k = layers.size(); k-- > 0;) {
    if (k + 1 < layers.size()) at = (trace[k + 1].array() > 0.0).select(at, 0.0);
    gradient[k].weight.noalias() += at.transpose() * trace[k];
    gradient[k].bias += at.colwise().sum().transpose();
    at = at * layers[k].weight;
  }
  return at;
}

double spectral_norm(const Eigen::MatrixXd& weight) {
  const bool wide = weight.cols() > weight.rows();
  const Eigen::MatrixXd gram =
      wide ? Eigen::MatrixXd(weight * weight.transpose()) : Eigen::MatrixXd(weight.transpose() * weight);
  return std::sqrt(std::max(
      0.0, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff()));
}

void bound_spectral_norm(Layers& layers, double most) {
  for (NetworkWeights::Layer& layer : layers) {
    // the Frobenius norm is never below it and costs nothing
    if (layer.weight.norm() <= most) continue;
    const double norm = spectral_norm(layer.weight);
    if (norm > most) layer.weight *= most / norm;
  }
}

void Adam::step(Layers& layers, const Layers& gradient) {
  constexpr double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;
  decay1_ *= beta1;
  decay2_ *= beta2;
  const auto move = [&](auto& value, auto& first, auto& second, const auto& slope) {
    first = beta1 * first + (1.0 - beta1) * slope;
    second = beta2 * second + (1.0 - beta2) * slope.cwiseAbs2();
    value.array() -= rate_ * (first.array() / (1.0 - decay1_)) / ((second.array() / (1.0 - decay2_)).sqrt() + epsilon);
  };
  for (std::size_t k = 0; k < layers.size(); ++k) {
    move(layers[k].weight, first_[k].weight, second_[k].weight, gradient[k].weight);
    move(layers[k].bias, first_[k].bias, second_[k].bias, gradient[k].bias);
  }
}

}  // namespace gustlab
