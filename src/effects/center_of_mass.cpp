// center_of_mass: the centre of mass is not where the MJCF says; hubs, and the point that is logged, move with it.
//
// r_c = r_MJCF + (x, y, z). Newton and Euler: arms of all forces, and p_log = p_com − R r_c.
#include "effects/effects.hpp"

namespace gustlab {

namespace {

class CenterOfMass final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    // the torque of 1.2 % of one of four rotors is 0.003 arms of centre of mass
    constexpr double natural = 0.02, tolerance = 0.003, plausible = 0.25;
    // Only a specific force to the side turns the vehicle by its height: drag, of a fifth of its weight at most in most flights.
    // It stands in for any moment that goes with the velocity, so that it is believed to be near the file's: 2.5 mm of a Crazyflie.
    constexpr double height_tolerance = 5.0 * tolerance, height_known_to = 0.05;
    visitor.number("x", offset_B_m_.x(),
                   {.unit = "m",
                    .help = "forward of the MJCF's centre of mass",
                    .natural = natural,
                    .tolerance = tolerance,
                    .scale = Scale::arm,
                    .plausible = plausible});
    visitor.number("y", offset_B_m_.y(),
                   {.unit = "m",
                    .help = "left of the MJCF's centre of mass",
                    .natural = natural,
                    .tolerance = tolerance,
                    .scale = Scale::arm,
                    .plausible = plausible});
    visitor.number("z", offset_B_m_.z(),
                   {.unit = "m",
                    .help = "above the MJCF's centre of mass",
                    .natural = natural,
                    .tolerance = height_tolerance,
                    .scale = Scale::arm,
                    .plausible = plausible,
                    .known_to = height_known_to});
  }

  void on_body(VehicleModel& vehicle) const override { vehicle.center_of_mass_B_m += offset_B_m_; }

 private:
  Vector3 offset_B_m_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Effect> make_center_of_mass() { return std::make_unique<CenterOfMass>(); }

}  // namespace gustlab
