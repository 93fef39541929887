// sindy_residual: a force in the world frame that is a sparse sum of terms of the flight's state.
//
// f_W = Σ ξ_i φ_i(x, u), as `gustlab identify` finds it (Brunton, Proctor, Kutz, PNAS 113, 2016; terms of arXiv
// 2603.08863, section II-A). It acts on the centre of mass.
#include "control/residual_model.hpp"
#include "effects/effects.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

class SindyResidual final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override { model_.visit(visitor); }

  void prepare(const VehicleModel&, double, const RandomStream&) override {
    try {
      model_.prepare();
    } catch (const ConfigError& error) {
      throw ConfigError(std::string("effect sindy_residual: ") + error.what());
    }
  }

  void wrench(const Flow& flow, const RotorSet& rotors, std::span<const double>, Wrench& total) const override {
    if (model_.coefficients().isZero(0.0)) return;
    FeatureInput input;
    input.position_W_m = flow.position_W_m;
    input.velocity_W_mps = flow.velocity_W_mps;
    input.body_rate_B_radps = flow.body_rate_B_radps;
    set_angles(input, flow.R_WB);
    for (int i = 0; i < rotors.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      input.thrust_N += rotors.thrust_N[k] * rotors.axis_B[k].z();
    }
    total.force_B_N += flow.R_WB.transpose() * model_.force_W_N(input);
  }

 private:
  ResidualModel model_;
};

}  // namespace

std::unique_ptr<Effect> make_sindy_residual() { return std::make_unique<SindyResidual>(); }

}  // namespace gustlab
