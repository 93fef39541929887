// wall_effect: a vehicle beside a wall is drawn toward it.
//
// F = strength × thrust × (R / d)² toward the wall, d ≥ R the distance of the body's origin. Robinson, Chung, Ryan, ICUAS
// 2014; Carter, Bouchard, Quinn, AIAA Journal 59(4) 2021 (side walls of micro-quadrotors).
#include <algorithm>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class WallEffect final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("strength", strength_,
                   {.unit = "-",
                    .help = "share of the thrust that pulls toward a wall one rotor radius away",
                    .min = 0.0,
                    .natural = 0.02});
  }

  void wrench(const Flow& flow, const RotorSet& rotors, std::span<const double>, Wrench& total) const override {
    if (strength_ == 0.0) return;
    double thrust_N = 0.0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rotors.count); ++i) thrust_N += rotors.thrust_N[i];
    const double radius_m = flow.vehicle->rotor_radius_m;
    for (const Environment::Wall& wall : flow.vehicle->environment.walls) {
      const double distance_m = std::max(wall.normal_W.dot(flow.position_W_m - wall.point_W_m), radius_m);
      const double ratio = radius_m / distance_m;
      total.force_B_N -= strength_ * thrust_N * ratio * ratio * (flow.R_WB.transpose() * wall.normal_W);
    }
  }

 private:
  double strength_ = 0.0;
};

}  // namespace

std::unique_ptr<Effect> make_wall_effect() { return std::make_unique<WallEffect>(); }

}  // namespace gustlab
