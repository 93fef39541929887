#include "control/adaptation.hpp"

#include <cmath>

namespace gustlab {

Adaptation::Adaptation(const Options& options, const Parameters& start, double period_s)
    : options_(options), period_s_(period_s), parameters_(start) {
  covariance_ = options.start_covariance * Covariance::Identity(start.rows(), start.rows());
}

Vector3 Adaptation::update(const Row& phi, const Vector3& measured, const Vector3& sliding) {
  const double keep = std::exp(-options_.leak_radps * period_s_);
  parameters_ *= keep;
  const Vector3 error = predict(phi) - measured;
  Row gain;  // Kᵀ

  if (options_.law == CovarianceLaw::corrected) {
    covariance_ *= keep * keep;
    covariance_.diagonal().array() += options_.growth * period_s_;
    // K = P φᵀ/(φ P φᵀ + R/T), P = (I − K φ) P (I − K φ)ᵀ + K R/T Kᵀ
    const Row P_phi = phi * covariance_;
    const double spread = P_phi.dot(phi) + options_.noise / period_s_;
    gain = P_phi / spread;
    covariance_.noalias() -= gain.transpose() * P_phi;
    covariance_.noalias() -= P_phi.transpose() * gain;
    covariance_.noalias() += spread * (gain.transpose() * gain);
    parameters_.noalias() -= gain.transpose() * error.transpose();
    parameters_.noalias() += period_s_ * (phi * covariance_).transpose() * sliding.transpose();
  } else {
    // P (I (1 + 2λT) + T φᵀφ/R) = P + Q T, with the inverse of the bracket by Sherman and Morrison
    const double a = 1.0 + 2.0 * options_.leak_radps * period_s_;
    const double b = period_s_ / options_.noise;
    covariance_.diagonal().array() += options_.growth * period_s_;
    const Row P_phi = phi * covariance_.transpose();
    covariance_.noalias() -= P_phi.transpose() * (b / (a + b * phi.squaredNorm()) * phi);
    covariance_ /= a;
    gain = phi * covariance_.transpose();  // (P φᵀ)ᵀ
    const double step = b / (1.0 + b * gain.dot(phi));
    parameters_.noalias() -= step * gain.transpose() * error.transpose();
    parameters_.noalias() += period_s_ * gain.transpose() * sliding.transpose();
  }
  return predict(phi);
}

}  // namespace gustlab
