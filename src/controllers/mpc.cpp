// mpc: linear model predictive control of the position, with the force that the model lacks estimated and cancelled.
//
// A second ahead, on the errors to the reference, with the lags of attitude and rotors, within the tilt limit and what the rotors can
// lift (control/predictive.hpp). The missing force is the measured one through a low-pass filter, as in the adaptive laws. Late poses are
// moved to the present by what the rotors pushed since.
//
// Kamel, Burri, Siegwart, IFAC 50(1) 2017 (linear, with a disturbance observer, on multirotors); Pannocchia & Rawlings, AIChE J. 49(2) 2003
// (without offset).
#include <algorithm>
#include <cmath>

#include "control/offboard.hpp"
#include "control/pid.hpp"
#include "control/predictive.hpp"
#include "controllers/controllers.hpp"

namespace gustlab {

namespace {

constexpr double shortest_lag_s = 0.005;

class Mpc {
 public:
  void visit(ParameterVisitor& visitor) {
    visitor.number("attitude_lag_s", attitude_lag_s_,
                   {.unit = "s",
                    .help = "lag of the horizontal acceleration behind what was asked for",
                    .min = shortest_lag_s,
                    .max = 1.0});
    visitor.number(
        "filter_hz", filter_hz_,
        {.unit = "Hz", .help = "how fast the missing force is estimated; 0: at once", .min = 0.0, .max = 100.0});
    visitor.number("limit_weights", limit_weights_,
                   {.help = "largest force that is cancelled on each axis, of the weight", .min = 0.0, .max = 2.0});
    visitor.integer("iterations", iterations_, {.help = "most steps towards the optimum", .min = 1, .max = 1000});
  }

  void reset(const OffboardSetup& setup) {
    const VehicleModel& vehicle = setup.vehicle;
    mass_kg_ = vehicle.mass_kg;
    gravity_mps2_ = vehicle.gravity_mps2;
    // so much lift that it is there at full tilt, too
    const double most_mps2 =
        0.95 * Mixer(vehicle).max_thrust_N() * std::cos(setup.tilt_limit_rad) / mass_kg_ - gravity_mps2_;
    control_ = PredictiveControl(
        PredictiveAxis(attitude_lag_s_, setup.bandwidth_radps, setup.damping),
        PredictiveAxis(std::max(shortest_lag_s, nominal_motor_lag_s(vehicle)), setup.bandwidth_radps, setup.damping),
        {gravity_mps2_ * std::tan(setup.tilt_limit_rad), -0.9 * gravity_mps2_, std::max(0.0, most_mps2)},
        static_cast<int>(iterations_));
    missing_ = LowPass1<Vector3>(time_constant_of(filter_hz_), setup.period_s, Vector3::Zero());
    estimate_W_mps2_.setZero();
  }

  Vector3 update(const OffboardInput& in) {
    const Vector3 gravity_W_mps2 = gravity_mps2_ * Vector3::UnitZ();
    estimate_W_mps2_ = limited(missing_.update(in.acceleration_W_mps2 + gravity_W_mps2 - in.thrust_W_N / mass_kg_),
                               Vector3::Constant(limit_weights_ * gravity_mps2_));

    const Vector3 gained = in.impulse_since_W_Ns / mass_kg_ + in.age_s * (estimate_W_mps2_ - gravity_W_mps2);
    const Vector3 velocity = in.seen.velocity_W_mps + gained;
    const Vector3 position = in.seen.position_W_m + in.age_s * (in.seen.velocity_W_mps + 0.5 * gained);
    const Vector3 acceleration = in.thrust_now_W_N / mass_kg_ - gravity_W_mps2 + estimate_W_mps2_;
    const Reference& goal = in.reference;
    Matrix3 error;
    error << position - goal.position_W_m, velocity - goal.velocity_W_mps, acceleration - goal.acceleration_W_mps2;

    for (std::size_t k = 0; k < PredictiveAxis::stages; ++k) {
      const double t = (static_cast<double>(k) + 0.5) * PredictiveAxis::stage_s;
      const Vector3 jerk = goal.jerk_W_mps3 + t * goal.snap_W_mps4;
      const Vector3 wanted =
          goal.acceleration_W_mps2 + t * (goal.jerk_W_mps3 + 0.5 * t * goal.snap_W_mps4) - estimate_W_mps2_;
      for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        u_ref_[i][k] = wanted[axis] + control_.axis(i).lag_s() * jerk[axis];
      }
    }
    const PredictiveControl::Inputs& w = control_.solve(error, u_ref_);
    const Vector3 asked(u_ref_[0][0] + w[0][0], u_ref_[1][0] + w[1][0], u_ref_[2][0] + w[2][0]);
    return mass_kg_ * (asked + gravity_W_mps2);
  }

  std::vector<std::string_view> telemetry_names() const { return {"force_x_N", "force_y_N", "force_z_N"}; }
  void telemetry(std::span<double> out) const {
    for (int i = 0; i < 3; ++i) out[static_cast<std::size_t>(i)] = mass_kg_ * estimate_W_mps2_[i];
  }

 private:
  double attitude_lag_s_ = 0.15, filter_hz_ = 1.0, limit_weights_ = 0.5;
  std::int64_t iterations_ = 50;

  double mass_kg_ = 1.0, gravity_mps2_ = 9.81;
  PredictiveControl control_;
  PredictiveControl::Inputs u_ref_{};
  LowPass1<Vector3> missing_;
  Vector3 estimate_W_mps2_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Controller> make_mpc() { return std::make_unique<Offboard<Mpc>>(); }

}  // namespace gustlab
