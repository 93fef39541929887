// Does the log contradict the vehicle file? Rotor order and directions come before any physics (DIAGNOSIS.md §3.9).
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

// Corrects the vehicle's rotors where the flights say clearly that order or directions are others, and says so.
std::vector<LogFinding> check_rotors(const std::vector<FlightData>& flights, VehicleModel& vehicle);

// Seconds by which the angular motion of the vehicle follows its (nominal) rotors' torques: cross-correlation of roll and pitch.
// std::nullopt when the flight does not say it clearly.
std::optional<double> torque_delay_s(const FlightData& flight, const VehicleModel& vehicle);

// Changes of the nominal torque (per hub's lever and (Ω/Ω_h)²) and of the angular acceleration about roll and pitch, per sample, over
// so short a time that trim and drag do not count; NaN at the ends.
struct AngularAccelerationSeries {
  std::vector<Eigen::Vector2d> torque, acceleration;
};
AngularAccelerationSeries angular_acceleration_series(const FlightData& flight, const VehicleModel& vehicle);

}  // namespace gustlab::diagnosis
