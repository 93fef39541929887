// my_controller: say here in one sentence what it does.
//
// Write the law, its symbols and where it is published. This one: F = m (a_d − K_p e_p − K_v e_v − K_i ∫ e_p) + m g, with PD gains
// that the vehicle's bandwidth w gives and K_i = integral w³/4; PD part and integral are each limited to some of the weight.
#include "control/offboard.hpp"
#include "control/pid.hpp"
#include "controllers/controllers.hpp"

namespace gustlab {

namespace {

// A force law; the vehicle's own loops turn it into attitude and rotor speeds (see control/offboard.hpp). A law that commands rotors
// itself derives from Controller (include/gustlab/controller.hpp) instead.
class MyController {
 public:
  // every parameter once: name, member, unit, help, bounds
  void visit(ParameterVisitor& visitor) {
    visitor.number("limit_weights", limit_,
                   {.help = "largest horizontal force, of the weight", .min = 0.0, .max = 2.0});
    visitor.number("integral", integral_, {.help = "K_i = integral w³/4; 0: none", .min = 0.0, .max = 100.0});
  }

  void reset(const OffboardSetup& setup) {
    mass_kg_ = setup.vehicle.mass_kg;
    weight_N_ = setup.vehicle.weight_N();
    const double w = setup.bandwidth_radps;
    gain_per_update_ = 0.25 * integral_ * w * w * w * setup.period_s * mass_kg_;
    sum_W_N_.setZero();
  }

  // force that the rotors should push with, world axes, N
  Vector3 update(const OffboardInput& in) {
    const Vector3 limit(limit_ * weight_N_, limit_ * weight_N_, weight_N_);
    sum_W_N_ = limited(sum_W_N_ + gain_per_update_ * in.position_error_W_m, limit);
    force_W_N_ = limited(mass_kg_ * in.acceleration_command_W_mps2, limit) - sum_W_N_;
    return force_W_N_ + weight_N_ * Vector3::UnitZ();
  }

  // columns of its own in flight.csv
  std::vector<std::string_view> telemetry_names() const { return {"force_x_N", "force_y_N", "force_z_N"}; }
  void telemetry(std::span<double> out) const {
    for (int i = 0; i < 3; ++i) out[static_cast<std::size_t>(i)] = force_W_N_[i];
  }

 private:
  double limit_ = 0.5, integral_ = 1.0;
  double mass_kg_ = 0.0, weight_N_ = 0.0, gain_per_update_ = 0.0;
  Vector3 force_W_N_ = Vector3::Zero(), sum_W_N_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Controller> make_my_controller() { return std::make_unique<Offboard<MyController>>(); }

}  // namespace gustlab
