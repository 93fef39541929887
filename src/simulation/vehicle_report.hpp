// A vehicle file examined: what it says of the vehicle, a hover flown in simulation, and where its numbers contradict each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simulation/flight.hpp"

namespace gustlab {

struct RotorTrim {
  std::string site;
  double speed_radps = 0.0;
  std::optional<double> throttle, pwm;  // inputs that ask for this speed, where the vehicle file has a map
};

// All of it with the file's own effects.
struct VehicleReport {
  double mass_kg = 0.0, weight_N = 0.0, arm_m = 0.0;
  std::optional<double> thrust_to_weight;      // std::nullopt: the file does not limit the rotors
  Vector3 authority_radps2 = Vector3::Zero();  // angular acceleration that hovering rotors can give about each axis
  std::optional<double> lag_up_s, lag_down_s;  // std::nullopt: the file has no motor_lag
  Outcome outcome = Outcome::completed;        // of the hover
  double flown_s = 0.0, error_m = 0.0, tilt_rad = 0.0;  // distance from the reference and mean tilt over its last half
  std::vector<RotorTrim> trim;                          // mean speeds over its last half
  std::vector<std::string> unknown;  // what the file leaves out, and what that makes not identifiable
  std::vector<std::string> contradictions;
};

// Flies ten seconds of hover with the geometric controller.
VehicleReport examine_vehicle(const VehicleModel& vehicle);
// What a vehicle file leaves out, and the effects that cannot be identified without it.
std::vector<std::string> unknown_numbers(const VehicleModel& vehicle);
// Numbers that cannot all be right, in words.
std::vector<std::string> contradictions(const VehicleModel& vehicle);

}  // namespace gustlab
