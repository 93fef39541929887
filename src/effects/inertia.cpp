// inertia: the moments of inertia differ from the model's; products of inertia grow so that their ratios stay.
//
// J_ii (1 + delta_i), J_ij √((1 + delta_i)(1 + delta_j)). Euler.
#include <cmath>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class Inertia final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    const auto axis = [&visitor](std::string_view name, double& delta) {
      visitor.number(name, delta,
                     {.unit = "-",
                      .help = "relative change of the moment of inertia",
                      .min = -0.9,
                      .max = 30.0,
                      .natural = 0.05,
                      .tolerance = 0.05,
                      .plausible = 1.0});  // twice what the file says; more is a lag, or a thrust map that is wrong
    };
    axis("delta_x", delta_.x());
    axis("delta_y", delta_.y());
    axis("delta_z", delta_.z());
  }

  void on_body(VehicleModel& vehicle) const override {
    const Vector3 growth = Vector3::Ones() + delta_;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) vehicle.inertia_B_kgm2(i, j) *= i == j ? growth[i] : std::sqrt(growth[i] * growth[j]);
  }

 private:
  Vector3 delta_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Effect> make_inertia() { return std::make_unique<Inertia>(); }

}  // namespace gustlab
