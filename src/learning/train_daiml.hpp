// DAIML: domain-adversarially invariant meta-learning of the features that the controller daiml adapts on.
//
// Algorithm 1 of Neural-Fly (O'Connell, Shi et al., Science Robotics 7(66) 2022): network 11–50–60–50–2, a constant 1 beside
// it (d = 3, shared by the axes, a is 3×3); discriminator d–20–conditions. In each epoch every condition gives one batch: 32
// samples to adapt on, 256 others to be predicted; Adam on the features, and with probability one half on the
// discriminator; spectral norm of every weight matrix at most 2.
#pragma once

#include <cstdint>
#include <span>

#include "learning/training_data.hpp"
#include "util/progress.hpp"

namespace gustlab {

struct TrainingOptions {
  std::int64_t epochs = 1000;
  double rate = 5e-4;                // of Adam
  double discriminator_share = 0.5;  // probability that a step updates it, too
  double spectral_norm = 2.0;
  Eigen::Index adapt_samples = 32;
  Eigen::Index test_samples = 256;
  MetaLossOptions loss;
  std::uint64_t seed = 1;
};

// Root mean square errors over samples and axes, m/s², of draws that adapt on `adapt_samples` of a condition and predict
// others of the same one.
struct ConditionFigures {
  std::string name;
  bool held_out = false;
  double residual_rms = 0.0;   // what there is to explain
  double mean_error = 0.0;     // of the mean of the adaptation set: the constant alone
  double network_error = 0.0;  // of the features with the coefficients adapted to the same set
};

struct Training {
  NetworkWeights network;
  std::vector<double> prediction, confusion;  // mean over the conditions, of every epoch
  double accuracy = 0.0;                      // of the discriminator over all training samples, each condition alike
  double probe_accuracy = 0.0;                // of one that learns from the finished features, when they no longer move
  double chance = 0.0;
  std::vector<ConditionFigures> conditions;
};

// The same bytes for the same conditions and seed. Throws ConfigError when a condition has too few samples.
Training train_daiml(std::span<const Condition> conditions, const TrainingOptions& options,
                     const ProgressReport& progress = {});

}  // namespace gustlab
