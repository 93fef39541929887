// sindy_residual: a force and a torque that are sparse sums of terms of the flight's state.
//
// f = Σ ξ_i φ_i(x, u), in world axes as `gustlab identify` finds it (Brunton, Proctor, Kutz, PNAS 113, 2016; terms of arXiv
// 2603.08863, section II-A) or in body axes as `gustlab diagnose` may; it acts on the centre of mass. The torque is in body
// axes.
#include <array>

#include "control/residual_model.hpp"
#include "effects/effects.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

class SindyResidual final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    model_.visit(visitor);
    visitor.text("frame", frame_, {.help = "axes of the force: world or body"});
    visitor.numbers(torque_names[0], torque_[0],
                    {.unit = "N m", .help = "per unit of each term, about body x; empty: none", .natural = 0.0});
    visitor.numbers(torque_names[1], torque_[1],
                    {.unit = "N m", .help = "per unit of each term, about body y; empty: none", .natural = 0.0});
    visitor.numbers(torque_names[2], torque_[2],
                    {.unit = "N m", .help = "per unit of each term, about body z; empty: none", .natural = 0.0});
  }

  void prepare(const VehicleModel&, double, const RandomStream&) override {
    model_.prepare();
    if (frame_ != "world" && frame_ != "body")
      throw ParameterError("frame", "frame = \"" + frame_ + "\" is neither world nor body");
    turns_ = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!torque_[axis].empty() && torque_[axis].size() != model_.terms().size())
        throw ParameterError(torque_names[axis], "tx, ty and tz must be empty or have one number per term");
      for (const double value : torque_[axis]) turns_ = turns_ || value != 0.0;
    }
  }

  void wrench(const Flow& flow, const RotorSet& rotors, std::span<const double>, Wrench& total) const override {
    const bool pushes = !model_.coefficients().isZero(0.0);
    if (!pushes && !turns_) return;
    FeatureInput input;
    input.position_W_m = flow.position_W_m;
    input.velocity_W_mps = flow.velocity_W_mps;
    input.body_rate_B_radps = flow.body_rate_B_radps;
    set_angles(input, flow.R_WB);
    for (int i = 0; i < rotors.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      input.thrust_N += rotors.thrust_N[k] * rotors.axis_B[k].z();
    }
    if (pushes) {
      const Vector3 force = model_.force_W_N(input);
      if (frame_ == "body") total.force_B_N += force;
      else total.force_B_N += flow.R_WB.transpose() * force;
    }
    if (!turns_) return;
    for (std::size_t i = 0; i < model_.terms().size(); ++i) {
      const double value = model_.terms()[i].value(input);
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (!torque_[axis].empty()) total.torque_B_Nm[static_cast<Eigen::Index>(axis)] += torque_[axis][i] * value;
    }
  }

 private:
  ResidualModel model_;
  std::string frame_ = "world";
  static constexpr std::array<std::string_view, 3> torque_names{"tx", "ty", "tz"};
  std::array<std::vector<double>, 3> torque_;
  bool turns_ = false;
};

}  // namespace

std::unique_ptr<Effect> make_sindy_residual() { return std::make_unique<SindyResidual>(); }

}  // namespace gustlab
