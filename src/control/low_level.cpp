#include "control/low_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/rotor_lead.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

LowLevel low_level_of(std::string_view choice, const VehicleModel& vehicle) {
  if (choice == "crazyflie") return LowLevel::crazyflie;
  if (choice == "ardupilot") return LowLevel::ardupilot;
  if (choice == "generic") return LowLevel::generic;
  if (choice != "auto")
    throw ParameterError("low_level",
                         fmt::format("low_level = \"{}\" is unknown (it names the attitude and rate loops); "
                                     "use auto, crazyflie, ardupilot or generic",
                                     choice));
  // a firmware's gains fit the vehicle that they were tuned on
  if (vehicle.rotor_count == 4) {
    if (vehicle.name == "crazyflie") return LowLevel::crazyflie;
    if (vehicle.name == "iris") return LowLevel::ardupilot;
  }
  return LowLevel::generic;
}

double base_rate_hz(LowLevel loop) {
  switch (loop) {
    case LowLevel::crazyflie:
      return 500.0;  // firmware: ATTITUDE_RATE
    case LowLevel::ardupilot:
      return 400.0;  // firmware: SCHED_LOOP_RATE
    case LowLevel::generic:
      return 500.0;
  }
  return 500.0;
}

std::unique_ptr<LowLevelLoop> make_low_level(LowLevel loop, const VehicleModel& vehicle, double period_s) {
  switch (loop) {
    case LowLevel::crazyflie:
      return make_crazyflie_loop(vehicle, period_s);
    case LowLevel::ardupilot:
      return make_ardupilot_loop(vehicle, period_s);
    case LowLevel::generic:
      return make_generic_loop(vehicle, period_s);
  }
  return nullptr;
}

Bandwidths bandwidths_of(const VehicleModel& vehicle, double period_s) {
  const Mixer mixer(vehicle);
  const Vector3 authority = vehicle.inertia_B_kgm2.inverse() * mixer.torque_authority_B_Nm();
  // a loop of bandwidth w around a lag τ wants w τ below about 0.4; half a radian of tilt error may use all the torque
  const double lag_s = RotorLead(vehicle, period_s).lag_s() + 1.5 * period_s;
  const auto rate = [&](double authority_radps2) {
    return std::min({25.0, 0.4 / lag_s, std::sqrt(6.0 * std::max(authority_radps2, 1e-3))});
  };
  Bandwidths out;
  out.rate = rate(authority.head<2>().cwiseAbs().minCoeff());
  out.yaw_rate = std::min(0.4 * out.rate, rate(std::abs(authority.z())));
  out.attitude = out.rate / 3.0;
  return out;
}

double attitude_bandwidth(LowLevel loop, const VehicleModel& vehicle, double period_s) {
  switch (loop) {
    case LowLevel::crazyflie:
      return 6.0;  // firmware: PID_ROLL_KP
    case LowLevel::ardupilot:
      return 4.5;  // firmware: ATC_ANG_RLL_P
    case LowLevel::generic:
      return bandwidths_of(vehicle, period_s).attitude;
  }
  return 0.0;
}

int ticks_per_update(std::string_view parameter, double rate_hz, double period_s) {
  const double ticks = 1.0 / (rate_hz * period_s);
  const double whole = std::round(ticks);
  if (!(whole >= 1.0) || std::abs(ticks - whole) > 1e-6 * whole)
    throw ParameterError(
        parameter,
        fmt::format("{} = {} does not divide the base rate of {:.6g} Hz (a slower loop runs every n-th tick); "
                    "use base rate / n",
                    parameter, rate_hz, 1.0 / period_s));
  return static_cast<int>(whole);
}

}  // namespace gustlab
