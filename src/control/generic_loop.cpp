// Attitude and rate loops for any multirotor of 3 to 8 rotors: gains from its own mass, inertia, rotor lag and torque limits.
//
// rate wanted = ω_a error; torque = J (ω_r (rate wanted − ω) + integral) + ω × J ω, then the vehicle's own mixer.
#include "control/attitude.hpp"
#include "control/low_level.hpp"
#include "control/pid.hpp"
#include "control/rotor_lead.hpp"
#include "control/rotors.hpp"

namespace gustlab {

namespace {

class GenericLoop final : public LowLevelLoop {
 public:
  GenericLoop(const VehicleModel& vehicle, double period_s)
      : period_s_(period_s),
        inertia_B_kgm2_(vehicle.inertia_B_kgm2),
        mixer_(vehicle),
        bandwidths_(bandwidths_of(vehicle, period_s)),
        lead_(vehicle, period_s) {
    const Vector3 rate(bandwidths_.rate, bandwidths_.rate, bandwidths_.yaw_rate);
    const Vector3 authority = (vehicle.inertia_B_kgm2.inverse() * mixer_.torque_authority_B_Nm()).cwiseAbs();
    gains_.p = rate;
    gains_.i = 0.25 * rate.cwiseProduct(rate) * 0.5;
    // the integral may take up to half of the torque there is
    gains_.integral_limit = 0.5 * authority.cwiseQuotient(gains_.i);
    // a rate that can be stopped again within about half a radian
    rate_limit_radps_ = authority.cwiseSqrt().cwiseMax(Vector3(0.5, 0.5, 0.2)).cwiseMin(Vector3::Constant(15.0));
    yaw_weight_ = vehicle.rotor_count > 3 ? 0.3 * bandwidths_.yaw_rate / bandwidths_.attitude : 0.0;
    yaw_controlled_ = vehicle.rotor_count > 3;
  }

  void reset(const Observation& first) override {
    rate_ = Pid(gains_);
    lead_.reset(first.rotor_speed_radps);
    command({0.0, first.attitude_WB});
  }

  void command(const ThrustAttitude& wanted) override { wanted_ = wanted; }

  RotorCommand update(const Observation& observation) override {
    const Vector3& rate = observation.body_rate_B_radps;
    const Vector3 error = attitude_error_B_rad(observation.attitude_WB, wanted_.attitude_WB, yaw_weight_);
    const Vector3 wanted_rate = limited(bandwidths_.attitude * error, rate_limit_radps_) + wanted_.body_rate_B_radps;
    Vector3 acceleration = rate_.update(wanted_rate - rate, Vector3::Zero(), period_s_);
    if (!yaw_controlled_) acceleration.z() = 0.0;
    const Vector3 torque = inertia_B_kgm2_ * acceleration + rate.cross(inertia_B_kgm2_ * rate);
    return lead_.update(mixer_.speeds(wanted_.thrust_N, torque));
  }

 private:
  double period_s_;
  Matrix3 inertia_B_kgm2_;
  Mixer mixer_;
  Bandwidths bandwidths_;
  PidGains gains_;
  Vector3 rate_limit_radps_ = Vector3::Zero();
  double yaw_weight_ = 0.0;
  bool yaw_controlled_ = true;
  RotorLead lead_;
  Pid rate_;
  ThrustAttitude wanted_;
};

}  // namespace

std::unique_ptr<LowLevelLoop> make_generic_loop(const VehicleModel& vehicle, double period_s) {
  return std::make_unique<GenericLoop>(vehicle, period_s);
}

}  // namespace gustlab
