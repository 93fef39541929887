// recorded_loop: how a vehicle turned under the controller that flew it. Not physics, and true of no other loop.
//
// ω̇ = C [ω, Rᵀe₃ (x, y), v_B (x, y), 1]: whatever else turns the vehicle is replaced. `gustlab diagnose` fits it where the recorded
// actuators predict body rates no better than holding them does; a habit of the closed loop, not of the vehicle (Ljung, System
// Identification, 1999, §13.4). Rollouts on recordings use it; where a controller of ours flies it is left out.
#include <array>

#include "effects/effects.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

class RecordedLoop final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
      visitor.numbers(axes[axis], per_[axis],
                      {.unit = "rad/s^2",
                       .help = "angular acceleration per body rate x y z [rad/s], world's up in body x y, velocity in "
                               "body x y [m/s], and constant; none given: nothing is replaced",
                       .natural = 0.0});
  }

  void prepare(const VehicleModel&, double, const RandomStream&) override {
    acts_ = false;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      if (!per_[axis].empty() && per_[axis].size() != terms)
        throw ParameterError(axes[axis], "roll, pitch and yaw must be empty or have 8 numbers");
      for (std::size_t i = 0; i < per_[axis].size(); ++i) acts_ = acts_ || per_[axis][i] != 0.0;
    }
  }

  void wrench(const Flow& flow, const RotorSet&, std::span<const double>, Wrench& total) const override {
    if (!acts_) return;
    const Vector3 &rate = flow.body_rate_B_radps, up = flow.R_WB.row(2),
                  velocity = flow.R_WB.transpose() * flow.velocity_W_mps;
    const std::array<double, terms> term = {rate.x(), rate.y(),     rate.z(),     up.x(),
                                            up.y(),   velocity.x(), velocity.y(), 1.0};
    Vector3 acceleration = Vector3::Zero();
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
      for (std::size_t i = 0; i < per_[axis].size(); ++i)
        acceleration[static_cast<Eigen::Index>(axis)] += per_[axis][i] * term[i];
    const Matrix3& inertia = flow.vehicle->inertia_B_kgm2;
    total.torque_B_Nm = inertia * acceleration + rate.cross(inertia * rate);
  }

 private:
  static constexpr std::size_t terms = 8;
  static constexpr std::array<std::string_view, 3> axes{"roll", "pitch", "yaw"};
  std::array<std::vector<double>, 3> per_;
  bool acts_ = false;
};

}  // namespace

std::unique_ptr<Effect> make_recorded_loop() { return std::make_unique<RecordedLoop>(); }

}  // namespace gustlab
