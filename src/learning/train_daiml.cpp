#include "learning/train_daiml.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "control/daiml_input.hpp"
#include "gustlab/errors.hpp"
#include "util/interrupt.hpp"

namespace gustlab {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index learned_features = 2;  // d − 1
constexpr int evaluation_draws = 200;
constexpr int probe_steps = 500;
constexpr double probe_rate = 5e-3;

// samples of a condition without repetition, drawn anew each time
class Sampler {
 public:
  explicit Sampler(const Samples& samples)
      : samples_(samples), order_(static_cast<std::size_t>(samples.inputs.rows())) {
    std::iota(order_.begin(), order_.end(), Index{0});
  }

  MetaBatch draw(Index condition, const TrainingOptions& options, Draws& draws) {
    const Index wanted = options.adapt_samples + options.test_samples, all = samples_.inputs.rows();
    for (Index i = 0; i < wanted; ++i)
      std::swap(order_[static_cast<std::size_t>(i)], order_[static_cast<std::size_t>(i + draws.below(all - i))]);
    const std::vector<Index> adapt(order_.begin(), order_.begin() + options.adapt_samples);
    const std::vector<Index> test(order_.begin() + options.adapt_samples, order_.begin() + wanted);
    return {{samples_.inputs(adapt, Eigen::all), samples_.residual(adapt, Eigen::all)},
            {samples_.inputs(test, Eigen::all), samples_.residual(test, Eigen::all)},
            condition};
  }

 private:
  const Samples& samples_;
  std::vector<Index> order_;
};

// mean and standard deviation of each input over the training conditions, each of equal weight
struct Normalisation {
  VectorXd mean = VectorXd::Zero(daiml_inputs), scale = VectorXd::Zero(daiml_inputs);
};
Normalisation normalisation_of(std::span<const Condition> conditions) {
  Normalisation out;
  double trained = 0.0;
  for (const Condition& condition : conditions)
    if (!condition.held_out) {
      out.mean += condition.samples.inputs.colwise().mean().transpose();
      trained += 1.0;
    }
  out.mean /= trained;
  for (const Condition& condition : conditions)
    if (!condition.held_out)
      out.scale += (condition.samples.inputs.rowwise() - out.mean.transpose()).cwiseAbs2().colwise().mean().transpose();
  // an input that never moves says nothing, and must not be blown up when it does
  out.scale = (out.scale / trained).cwiseSqrt().cwiseMax(1e-3);
  return out;
}

ConditionFigures evaluate(const Condition& condition, const Samples& normalised, const Layers& features,
                          const TrainingOptions& options, Draws& draws) {
  Sampler sampler(normalised);
  double mean = 0.0, network = 0.0, count = 0.0;
  for (int draw = 0; draw < evaluation_draws; ++draw) {
    const MetaBatch batch = sampler.draw(0, options, draws);
    const MatrixXd& truth = batch.test.residual;
    const MatrixXd a = adapt(features_at(features, batch.adapt.inputs), batch.adapt.residual, options.loss);
    network += (features_at(features, batch.test.inputs) * a - truth).squaredNorm();
    mean += (truth.rowwise() - batch.adapt.residual.colwise().mean()).squaredNorm();
    count += static_cast<double>(truth.size());
  }
  const double rms = std::sqrt(normalised.residual.squaredNorm() / static_cast<double>(normalised.residual.size()));
  return {condition.name, condition.held_out, rms, std::sqrt(mean / count), std::sqrt(network / count)};
}

// A discriminator that was not part of the training learns to tell the conditions from the finished features, all of them in
// every step, and is tested on draws of its own: what the features still give away, whatever the adversary had learned.
double probe_accuracy(std::span<const Samples> phi, const TrainingOptions& options, Draws& draws) {
  std::vector<Sampler> samplers(phi.begin(), phi.end());
  const auto count = static_cast<Index>(phi.size());
  const auto draw = [&](Index c) { return samplers[static_cast<std::size_t>(c)].draw(c, options, draws).test.inputs; };
  Layers probe = random_layers({learned_features + 1, 20, count}, draws);
  Adam steps(probe, probe_rate);
  for (int step = 0; step < probe_steps; ++step) {
    Layers gradient = zeros_like(probe);
    for (Index c = 0; c < count; ++c) discriminator_loss(probe, draw(c), c, gradient);
    steps.step(probe, gradient);
  }
  double accuracy = 0.0;
  for (Index c = 0; c < count; ++c)
    for (int k = 0; k < evaluation_draws; ++k) accuracy += discriminator_accuracy(probe, draw(c), c);
  return accuracy / static_cast<double>(count * evaluation_draws);
}

void check(std::span<const Condition> conditions, const TrainingOptions& options) {
  const Index wanted = options.adapt_samples + options.test_samples;
  for (const Condition& condition : conditions)
    if (condition.samples.inputs.rows() < wanted)
      throw ConfigError(fmt::format("condition \"{}\": {} samples (a batch takes {}); fly longer, or log faster",
                                    condition.name, condition.samples.inputs.rows(), wanted));
}

// Fisher–Yates
void shuffle(std::vector<Index>& order, Draws& draws) {
  for (std::size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[static_cast<std::size_t>(draws.below(static_cast<Index>(i) + 1))]);
}

}  // namespace

Training train_daiml(std::span<const Condition> conditions, const TrainingOptions& options,
                     const ProgressReport& progress) {
  check(conditions, options);
  const Normalisation normal = normalisation_of(conditions);
  std::vector<Samples> normalised;
  std::vector<std::size_t> trained;
  for (const Condition& condition : conditions) {
    if (!condition.held_out) trained.push_back(normalised.size());
    MatrixXd inputs = condition.samples.inputs.rowwise() - normal.mean.transpose();
    normalised.push_back({inputs * normal.scale.cwiseInverse().asDiagonal(), condition.samples.residual});
  }
  std::vector<Sampler> samplers;
  for (const std::size_t c : trained) samplers.emplace_back(normalised[c]);

  // one step per condition and epoch
  Draws draws(RandomStream(options.seed, 0, "daiml_training"));
  const auto count = static_cast<Index>(trained.size());
  Layers features = random_layers({daiml_inputs, 50, 60, 50, learned_features}, draws);
  Layers discriminator = random_layers({learned_features + 1, 20, count}, draws);
  Adam feature_steps(features, options.rate), discriminator_steps(discriminator, options.rate);
  std::vector<Index> order(trained.size());
  std::iota(order.begin(), order.end(), Index{0});
  Training training;
  for (std::int64_t epoch = 0; epoch < options.epochs; ++epoch) {
    throw_if_interrupted();
    if (progress) progress("epochs", static_cast<double>(epoch) / static_cast<double>(options.epochs));
    double prediction = 0.0, confusion = 0.0;
    shuffle(order, draws);
    for (const Index condition : order) {
      const MetaBatch batch = samplers[static_cast<std::size_t>(condition)].draw(condition, options, draws);
      Layers gradient = zeros_like(features);
      const MetaLoss loss = feature_loss(features, discriminator, batch, options.loss, gradient);
      feature_steps.step(features, gradient);
      bound_spectral_norm(features, options.spectral_norm);
      prediction += loss.prediction / static_cast<double>(count);
      confusion += loss.confusion / static_cast<double>(count);
      if (draws.uniform() >= options.discriminator_share) continue;
      Layers slope = zeros_like(discriminator);
      discriminator_loss(discriminator, features_at(features, batch.test.inputs), condition, slope);
      discriminator_steps.step(discriminator, slope);
    }
    training.prediction.push_back(prediction);
    training.confusion.push_back(confusion);
  }

  training.chance = 1.0 / static_cast<double>(count);
  Draws evaluation(RandomStream(options.seed, 0, "daiml_evaluation"));
  std::vector<Samples> phi;
  for (const std::size_t c : trained) {
    phi.push_back({features_at(features, normalised[c].inputs), normalised[c].residual});
    training.accuracy +=
        training.chance * discriminator_accuracy(discriminator, phi.back().inputs, static_cast<Index>(phi.size()) - 1);
  }
  training.probe_accuracy = probe_accuracy(phi, options, evaluation);
  for (std::size_t c = 0; c < conditions.size(); ++c)
    training.conditions.push_back(evaluate(conditions[c], normalised[c], features, options, evaluation));
  training.network = {{}, {daiml_input_names.begin(), daiml_input_names.end()}, normal.mean, normal.scale, features};
  return training;
}

}  // namespace gustlab
