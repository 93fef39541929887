// slung_load: a point mass swings below the centre of mass on a massless cable of fixed length.
//
// Hidden state: direction n of the cable (down to the load) and its rate ω ⟂ n, both in W. With f the force on the vehicle
// without weight and cable: tension T = m_l m / (m_l + m) (L |ω|² − n·f/m), never negative (a cable cannot push), and the
// vehicle is pulled by T n; ω̇ = −n × f/(m L). Sreenath, Lee, Kumar, CDC 2013, eq. (1)–(4), here with n integrated on the
// sphere by semi-implicit Euler, as the plant integrates the body.
#include <algorithm>
#include <cmath>

#include "effects/effects.hpp"

namespace gustlab {

namespace {

class SlungLoad final : public Effect {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.number("mass", mass_kg_,
                   {.unit = "kg", .help = "of the load", .min = 0.0, .natural = 0.01, .scale = Scale::weight});
    visitor.number("length", length_m_,
                   {.unit = "m",
                    .help = "of the cable",
                    .min = 0.02,
                    .natural = 6.0,
                    .scale = Scale::arm,
                    .fitted = Fitted::never});
  }

  int state_size() const override { return 6; }

  void reset_state(std::span<double> state) const override {
    std::fill(state.begin(), state.end(), 0.0);
    state[2] = -1.0;  // hangs
  }

  void wrench(const Flow& flow, const RotorSet&, std::span<const double> state, Wrench& total) const override {
    if (mass_kg_ == 0.0) return;
    const Vector3 cable_B = flow.R_WB.transpose() * Eigen::Map<const Vector3>(state.data());
    const Eigen::Map<const Vector3> rate_W_radps(state.data() + 3);
    const double mass_kg = flow.vehicle->mass_kg;
    const double reduced_kg = mass_kg_ * mass_kg / (mass_kg_ + mass_kg);
    const double tension_N =
        reduced_kg * (length_m_ * rate_W_radps.squaredNorm() - cable_B.dot(total.force_B_N) / mass_kg);
    total.force_B_N += std::max(tension_N, 0.0) * cable_B;
  }

  void advance(const Flow& flow, const RotorSet&, const Wrench& total, double step_s,
               std::span<double> state) const override {
    Eigen::Map<Vector3> cable_W(state.data()), rate_W_radps(state.data() + 3);
    // the cable's own pull is along n and drops out
    const Vector3 acceleration_W_mps2 = flow.R_WB * total.force_B_N / flow.vehicle->mass_kg;
    Vector3 rate = rate_W_radps - step_s / length_m_ * cable_W.cross(acceleration_W_mps2);
    const double angle = rate.norm() * step_s;
    if (angle > 0.0) cable_W = Eigen::AngleAxisd(angle, rate.normalized()) * Vector3(cable_W);
    // rounding leaves neither the sphere nor its tangent
    cable_W.normalize();
    rate -= cable_W.dot(rate) * cable_W;
    rate_W_radps = rate;
  }

 private:
  double mass_kg_ = 0.0, length_m_ = 0.3;
};

}  // namespace

std::unique_ptr<Effect> make_slung_load() { return std::make_unique<SlungLoad>(); }

}  // namespace gustlab
