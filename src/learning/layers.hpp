// The layers of a small network for training: whole batches forward and backward, Adam, and the bound on the spectral norm.
//
// Rows of a batch are samples. All layers but the last are followed by max(0, ·), as in control/network.hpp, which
// evaluates what is trained here.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "control/network.hpp"
#include "gustlab/random.hpp"

namespace gustlab {

using Layers = std::vector<NetworkWeights::Layer>;

// Numbers of one random stream, one after the other.
class Draws {
 public:
  explicit Draws(const RandomStream& stream) : stream_(stream) {}
  double uniform() { return stream_.uniform4(counter_++)[0]; }  // in (0, 1)
  double normal() { return stream_.normal4(counter_++)[0]; }
  Eigen::Index below(Eigen::Index count) { return static_cast<Eigen::Index>(uniform() * static_cast<double>(count)); }

 private:
  RandomStream stream_;
  std::uint64_t counter_ = 0;
};

// Widths from the input to the output. Weights of variance 2/inputs (He et al., ICCV 2015), biases zero.
Layers random_layers(std::initializer_list<Eigen::Index> widths, Draws& draws);
Layers zeros_like(const Layers& layers);

// Every layer's value, the input first.
using Trace = std::vector<Eigen::MatrixXd>;
Trace forward(const Layers& layers, const Eigen::MatrixXd& input);
// From the gradient at the output: adds the gradient at the parameters to `gradient`, returns that at the input.
Eigen::MatrixXd backward(const Layers& layers, const Trace& trace, const Eigen::MatrixXd& at_output, Layers& gradient);

// Scales every weight matrix whose largest singular value is above `most` down to it.
void bound_spectral_norm(Layers& layers, double most);
double spectral_norm(const Eigen::MatrixXd& weight);

// Kingma & Ba, ICLR 2015, with its usual constants.
class Adam {
 public:
  Adam(const Layers& layers, double rate) : first_(zeros_like(layers)), second_(zeros_like(layers)), rate_(rate) {}
  void step(Layers& layers, const Layers& gradient);

 private:
  Layers first_, second_;
  double rate_;
  double decay1_ = 1.0, decay2_ = 1.0;  // β₁ᵗ, β₂ᵗ
};

}  // namespace gustlab
