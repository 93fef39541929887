// geometric: F = m (a_d − K_p e_p − K_v e_v − K_i ∫ s) + m g, thrust along the present axis, attitude along F.
//
// Lee, Leok, McClamroch, CDC 2010, doi 10.1109/CDC.2010.5717652; integral: Goodarzi, Lee, Lee, ECC 2013. The attitude part
// is the vehicle's own low-level loops. Without the integral (0) it is the PD of the paper's adaptive controllers.
#include "control/offboard.hpp"
#include "control/pid.hpp"
#include "controllers/controllers.hpp"

namespace gustlab {

namespace {

class Geometric {
 public:
  void visit(ParameterVisitor& visitor) {
    visitor.number("integral", integral_, {.help = "K_i = integral w³/4; 0: none", .min = 0.0, .max = 1000.0});
    visitor.number("integral_limit_mps2", limit_mps2_,
                   {.unit = "m/s^2", .help = "largest acceleration of the integral", .min = 0.0, .max = 50.0});
  }

  void reset(const OffboardSetup& setup) {
    mass_kg_ = setup.vehicle.mass_kg;
    weight_W_N_ = setup.vehicle.weight_N() * Vector3::UnitZ();
    period_s_ = setup.period_s;
    w_ = setup.bandwidth_radps;
    sum_W_mps2_.setZero();
  }

  Vector3 update(const OffboardInput& in) {
    // s = e_p + e_v/w: the position error with some lead
    const Vector3 s = in.position_error_W_m + in.velocity_error_W_mps / w_;
    sum_W_mps2_ =
        limited(sum_W_mps2_ + 0.25 * integral_ * w_ * w_ * w_ * period_s_ * s, Vector3::Constant(limit_mps2_));
    return mass_kg_ * (in.acceleration_command_W_mps2 - sum_W_mps2_) + weight_W_N_;
  }

  std::vector<std::string_view> telemetry_names() const { return {"force_x_N", "force_y_N", "force_z_N"}; }
  void telemetry(std::span<double> out) const {
    for (int i = 0; i < 3; ++i) out[static_cast<std::size_t>(i)] = mass_kg_ * sum_W_mps2_[i];
  }

 private:
  double integral_ = 1.0, limit_mps2_ = 4.0;
  double mass_kg_ = 0.0, period_s_ = 0.02, w_ = 1.0;
  Vector3 weight_W_N_ = Vector3::Zero(), sum_W_mps2_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Controller> make_geometric() { return std::make_unique<Offboard<Geometric>>(); }

}  // namespace gustlab
