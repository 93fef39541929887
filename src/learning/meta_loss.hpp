// What DAIML minimises, and its gradients (Algorithm 1 of O'Connell, Shi et al., Neural-Fly, Science Robotics 7(66) 2022,
// and Shi, Azizzadenesheli, O'Connell, Chung, Yue, NeurIPS 2021).
//
//   Φ = [network(x), 1]       a* = argmin ‖Y_K − Φ_K a‖² + ρ ‖a‖², shortened to ‖a‖ ≤ γ
//   features:       mean ‖y − Φ a*‖² over the batch  −  α × cross-entropy of the discriminator
//   discriminator:  its cross-entropy, of telling from Φ which condition the batch was flown in
//
// The gradient goes through a*, so that what is learned is features that 32 samples are enough to fit.
#pragma once

#include "learning/layers.hpp"

namespace gustlab {

struct MetaLossOptions {
  double adversary = 0.01;  // α
  double longest = 10.0;    // γ, of ‖a‖
  double ridge = 1e-3;      // ρ, per sample: 32 samples of features that are alike must not divide by zero
};

// Samples of one condition; inputs as the network sees them, residual accelerations in m/s².
struct Samples {
  Eigen::MatrixXd inputs;    // samples × 11
  Eigen::MatrixXd residual;  // samples × 3
};
struct MetaBatch {
  Samples adapt, test;
  Eigen::Index condition = 0;
};

// Φ = [network(x), 1], samples × d.
Eigen::MatrixXd features_at(const Layers& network, const Eigen::MatrixXd& inputs);
// a*, d × 3.
Eigen::MatrixXd adapt(const Eigen::MatrixXd& phi, const Eigen::MatrixXd& residual, const MetaLossOptions& options);

struct MetaLoss {
  double prediction = 0.0;  // mean over samples and axes of the squared error, (m/s²)²
  double confusion = 0.0;   // cross-entropy of the discriminator, nat
  double total(const MetaLossOptions& options) const { return prediction - options.adversary * confusion; }
};
// Adds the gradient of the total at the network to `gradient`.
MetaLoss feature_loss(const Layers& network, const Layers& discriminator, const MetaBatch& batch,
                      const MetaLossOptions& options, Layers& gradient);
// The discriminator's cross-entropy on features of one condition; adds its gradient at the discriminator to `gradient`.
double discriminator_loss(const Layers& discriminator, const Eigen::MatrixXd& phi, Eigen::Index condition,
                          Layers& gradient);
// Share of samples whose condition the discriminator names rightly.
double discriminator_accuracy(const Layers& discriminator, const Eigen::MatrixXd& phi, Eigen::Index condition);

}  // namespace gustlab
