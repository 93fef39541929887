// l1: the paper's PD plus an L1 adaptive estimate of the force.
//
//   v̂' = a_s (v̂ − v) − g e_z + (u + σ̂)/m       σ̂ = −m φ⁻¹ e^(a_s T) (v̂ − v),  φ = (e^(a_s T) − 1)/a_s
// piecewise constant adaptation, and only its low-passed part is cancelled: F = m a_cmd + m g − C(s) σ̂.
// Hovakimyan & Cao, L1 Adaptive Control Theory, SIAM 2010, ch. 3.3; on quadrotors Wu et al., IEEE TCST 2025 (L1Quad).
#include "control/offboard.hpp"
#include "control/pid.hpp"
#include "controllers/controllers.hpp"

namespace gustlab {

namespace {

class L1 {
 public:
  void visit(ParameterVisitor& visitor) {
    visitor.number("predictor_radps", predictor_radps_,
                   {.unit = "rad/s", .help = "−a_s of the state predictor", .min = 0.001, .max = 200.0});
    visitor.number("filter_hz", filter_hz_,
                   {.unit = "Hz", .help = "C(s): how fast a force is cancelled", .min = 0.0, .max = 50.0});
    visitor.number("limit_weights", limit_,
                   {.help = "largest force that is cancelled on each axis, of the weight", .min = 0.0, .max = 2.0});
  }

  void reset(const OffboardSetup& setup) {
    mass_kg_ = setup.vehicle.mass_kg;
    weight_N_ = setup.vehicle.weight_N();
    period_s_ = setup.period_s;
    filter_ = LowPass1<Vector3>(time_constant_of(filter_hz_), period_s_, Vector3::Zero());
    gap_W_mps_.setZero();
    force_W_N_.setZero();
    estimate_W_N_.setZero();
  }

  Vector3 update(const OffboardInput& in) {
    const Vector3 weight_W_N = weight_N_ * Vector3::UnitZ();
    // v̂ − v over the interval that ends now, with what drove the vehicle in it
    const double a = -predictor_radps_;
    const double decay = std::exp(a * period_s_);
    const double phi = (decay - 1.0) / a;
    const Vector3 forced = (in.thrust_W_N - weight_W_N + force_W_N_) / mass_kg_;
    gap_W_mps_ = decay * gap_W_mps_ + phi * (forced - in.acceleration_W_mps2);
    force_W_N_ = -mass_kg_ * decay / phi * gap_W_mps_;
    estimate_W_N_ = limited(filter_.update(force_W_N_), Vector3::Constant(limit_ * weight_N_));
    return mass_kg_ * in.acceleration_command_W_mps2 + weight_W_N - estimate_W_N_;
  }

  std::vector<std::string_view> telemetry_names() const { return {"force_x_N", "force_y_N", "force_z_N"}; }
  void telemetry(std::span<double> out) const {
    for (int i = 0; i < 3; ++i) out[static_cast<std::size_t>(i)] = estimate_W_N_[i];
  }

 private:
  double predictor_radps_ = 1.0, filter_hz_ = 0.6, limit_ = 0.5;
  double mass_kg_ = 0.0, weight_N_ = 0.0, period_s_ = 0.02;
  LowPass1<Vector3> filter_;
  Vector3 gap_W_mps_ = Vector3::Zero();
  Vector3 force_W_N_ = Vector3::Zero(), estimate_W_N_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Controller> make_l1() { return std::make_unique<Offboard<L1>>(); }

}  // namespace gustlab
