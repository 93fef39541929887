#include "learning/meta_loss.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace gustlab {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// least squares before it is shortened, and what its gradient needs
struct Fit {
  Eigen::LLT<MatrixXd> gram;
  MatrixXd a;
};
Fit fit(const MatrixXd& phi, const MatrixXd& residual, const MetaLossOptions& options) {
  MatrixXd gram = phi.transpose() * phi;
  gram.diagonal().array() += options.ridge * static_cast<double>(phi.rows());
  Fit out{gram.llt(), {}};
  out.a = out.gram.solve(phi.transpose() * residual);
  return out;
}

double shortening(const MatrixXd& a, const MetaLossOptions& options) {
  return std::min(1.0, options.longest / a.norm());
}

// mean of −log softmax at the condition; its gradient at the logits
struct CrossEntropy {
  double mean;
  MatrixXd at_logits;
};
CrossEntropy cross_entropy(const MatrixXd& logits, Index condition) {
  MatrixXd share = (logits.colwise() - logits.rowwise().maxCoeff()).array().exp();
  const Eigen::VectorXd sum = share.rowwise().sum();
  share.array().colwise() /= sum.array();
  const double n = static_cast<double>(logits.rows());
  const double mean = -share.col(condition).array().log().sum() / n;
  share.col(condition).array() -= 1.0;
  return {mean, share / n};
}

MatrixXd with_constant(const MatrixXd& outputs) {
  MatrixXd phi(outputs.rows(), outputs.cols() + 1);
  phi << outputs, Eigen::VectorXd::Ones(outputs.rows());
  return phi;
}

}  // namespace

MatrixXd features_at(const Layers& network, const MatrixXd& inputs) {
  return with_constant(forward(network, inputs).back());
}

MatrixXd adapt(const MatrixXd& phi, const MatrixXd& residual, const MetaLossOptions& options) {
  const MatrixXd a = fit(phi, residual, options).a;
  return shortening(a, options) * a;
}

MetaLoss feature_loss(const Layers& network, const Layers& discriminator, const MetaBatch& batch,
                      const MetaLossOptions& options, Layers& gradient) {
  const Index k = batch.adapt.inputs.rows(), b = batch.test.inputs.rows();
  MatrixXd inputs(k + b, batch.test.inputs.cols());
  inputs << batch.adapt.inputs, batch.test.inputs;
  const Trace trace = forward(network, inputs);
  const MatrixXd phi = with_constant(trace.back());
  const auto phi_k = phi.topRows(k), phi_b = phi.bottomRows(b);

  const Fit fitted = fit(phi_k, batch.adapt.residual, options);
  const double shorter = shortening(fitted.a, options);
  const MatrixXd a = shorter * fitted.a;
  const MatrixXd error = phi_b * a - batch.test.residual;
  const Trace told = forward(discriminator, phi_b);
  const CrossEntropy confusion = cross_entropy(told.back(), batch.condition);

  // at the batch's features: directly, and through the discriminator
  MatrixXd at_phi = MatrixXd::Zero(phi.rows(), phi.cols());
  const MatrixXd at_error = 2.0 / static_cast<double>(error.size()) * error;
  Layers unused = zeros_like(discriminator);
  at_phi.bottomRows(b) =
      at_error * a.transpose() - options.adversary * backward(discriminator, told, confusion.at_logits, unused);
  // at the adaptation set's features, through a: with M a = Φᵀ Y and H = M⁻¹ G, G at a: (Y − Φ a) Hᵀ − Φ H aᵀ
  MatrixXd at_a = phi_b.transpose() * at_error;
  if (shorter < 1.0) at_a = shorter * (at_a - fitted.a * (fitted.a.cwiseProduct(at_a).sum() / fitted.a.squaredNorm()));
  const MatrixXd h = fitted.gram.solve(at_a);
  at_phi.topRows(k) = (batch.adapt.residual - phi_k * fitted.a) * h.transpose() - phi_k * h * fitted.a.transpose();

  backward(network, trace, at_phi.leftCols(phi.cols() - 1), gradient);
  return {error.squaredNorm() / static_cast<double>(error.size()), confusion.mean};
}

double discriminator_loss(const Layers& discriminator, const MatrixXd& phi, Index condition, Layers& gradient) {
  const Trace told = forward(discriminator, phi);
  const CrossEntropy confusion = cross_entropy(told.back(), condition);
  backward(discriminator, told, confusion.at_logits, gradient);
  return confusion.mean;
}

double discriminator_accuracy(const Layers& discriminator, const MatrixXd& phi, Index condition) {
  const MatrixXd logits = forward(discriminator, phi).back();
  Index right = 0, named = 0;
  for (Index i = 0; i < logits.rows(); ++i) {
    logits.row(i).maxCoeff(&named);
    right += named == condition ? 1 : 0;
  }
  return static_cast<double>(right) / static_cast<double>(logits.rows());
}

}  // namespace gustlab
