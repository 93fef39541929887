// Low-level loops: from thrust and attitude to rotor speeds, as each firmware does it. Every controller that thinks in
// thrust and attitude is composed with one of them.
#pragma once

#include <memory>
#include <string_view>

#include "gustlab/types.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// What an outer loop asks for.
struct ThrustAttitude {
  double thrust_N = 0.0;  // along body z
  Quaternion attitude_WB = Quaternion::Identity();
  Vector3 body_rate_B_radps = Vector3::Zero();  // feed-forward; the firmwares have no use for it
};

class LowLevelLoop {
 public:
  virtual ~LowLevelLoop() = default;
  virtual void reset(const Observation& first) = 0;
  // held until the next one
  virtual void command(const ThrustAttitude& wanted) = 0;
  // at the base rate
  virtual RotorCommand update(const Observation& observation) = 0;
};

enum class LowLevel { crazyflie, ardupilot, generic };

// automatic, crazyflie, ardupilot or generic; automatic goes by the vehicle's name. Throws ParameterError on any other.
LowLevel low_level_of(std::string_view choice, const VehicleModel& vehicle);
inline constexpr std::string_view low_level_help =
    "attitude and rate loops: auto, crazyflie, ardupilot (both as their firmware) or generic (gains from mass and "
    "inertia)";

// Rate at which update() is called: Crazyflie 500 Hz, ArduPilot 400 Hz, generic 500 Hz.
double base_rate_hz(LowLevel loop);

std::unique_ptr<LowLevelLoop> make_crazyflie_loop(const VehicleModel& vehicle, double period_s);
std::unique_ptr<LowLevelLoop> make_ardupilot_loop(const VehicleModel& vehicle, double period_s);
std::unique_ptr<LowLevelLoop> make_generic_loop(const VehicleModel& vehicle, double period_s);
std::unique_ptr<LowLevelLoop> make_low_level(LowLevel loop, const VehicleModel& vehicle, double period_s);

// Bandwidths that a vehicle's rotors allow, rad/s; what the generic loops and every position law's defaults are made of.
struct Bandwidths {
  double rate = 25.0;
  double yaw_rate = 8.0;
  double attitude = 8.0;
};
Bandwidths bandwidths_of(const VehicleModel& vehicle, double period_s);
// The attitude bandwidth that a position law may count on.
double attitude_bandwidth(LowLevel loop, const VehicleModel& vehicle, double period_s);

// How many base ticks make one tick of a slower loop. Throws ParameterError, of `parameter`, when that is no whole number.
int ticks_per_update(std::string_view parameter, double rate_hz, double period_s);

}  // namespace gustlab
