#include "control/residual.hpp"

#include "control/pid.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

void ResidualAdaptation::visit(ParameterVisitor& visitor) {
  visitor.number("leak_radps", options_.leak_radps,
                 {.unit = "1/s", .help = "lambda: how fast parameters are forgotten", .min = 0.0, .max = 10.0});
  visitor.number("noise", options_.noise,
                 {.unit = "1/s", .help = "R of the measured residual, beside P in 1/s^2", .min = 1e-6, .max = 1e6});
  visitor.number("growth", options_.growth, {.unit = "1/s^3", .help = "Q = growth I", .min = 0.0, .max = 1e6});
  visitor.number("start_covariance", options_.start_covariance,
                 {.unit = "1/s^2", .help = "P(0) = start_covariance I", .min = 1e-9, .max = 1e6});
  visitor.text("covariance_law", covariance_law_,
               {.help = "corrected, or printed: the paper's, without the trailing P"});
  visitor.number("sliding_radps", sliding_radps_,
                 {.unit = "rad/s", .help = "Lambda of s = e_v + Lambda e_p", .min = 0.0, .max = 50.0});
  visitor.number("filter_hz", filter_hz_,
                 {.unit = "Hz", .help = "low-pass of a_meas and u_prev; 0: none", .min = 0.0, .max = 100.0});
  visitor.number("limit_weights", limit_weights_,
                 {.help = "largest force that is cancelled on each axis, of the weight", .min = 0.0, .max = 2.0});
}

void ResidualAdaptation::reset(const OffboardSetup& setup, const Adaptation::Parameters& start) {
  if (covariance_law_ != "corrected" && covariance_law_ != "printed")
    throw ParameterError("covariance_law", "covariance_law = \"" + covariance_law_ +
                                               "\" is unknown (how P evolves); use corrected or printed");
  options_.law = covariance_law_ == "printed" ? CovarianceLaw::printed : CovarianceLaw::corrected;
  mass_kg_ = setup.vehicle.mass_kg;
  weight_N_ = setup.vehicle.weight_N();
  adaptation_ = Adaptation(options_, start, setup.period_s);
  filter_ = LowPass1<Vector3>(time_constant_of(filter_hz_), setup.period_s, Vector3::Zero());
  residual_W_mps2_.setZero();
  estimate_W_mps2_.setZero();
}

Vector3 ResidualAdaptation::update(const OffboardInput& in, const Adaptation::Row& phi) {
  const Vector3 weight_W_N = weight_N_ * Vector3::UnitZ();
  // the filter is linear: filtering the sum filters a_meas and u_prev alike
  residual_W_mps2_ = filter_.update(in.acceleration_W_mps2 + (weight_W_N - in.thrust_W_N) / mass_kg_);
  const Vector3 sliding = in.velocity_error_W_mps + sliding_radps_ * in.position_error_W_m;
  const double limit_mps2 = limit_weights_ * weight_N_ / mass_kg_;
  estimate_W_mps2_ = limited(adaptation_.update(phi, residual_W_mps2_, sliding), Vector3::Constant(limit_mps2));
  return mass_kg_ * (in.acceleration_command_W_mps2 - estimate_W_mps2_) + weight_W_N;
}

void ResidualAdaptation::telemetry(std::span<double> out) const {
  for (int i = 0; i < 3; ++i) {
    out[static_cast<std::size_t>(i)] = mass_kg_ * estimate_W_mps2_[i];
    out[static_cast<std::size_t>(i) + 3] = mass_kg_ * residual_W_mps2_[i];
  }
}

}  // namespace gustlab
