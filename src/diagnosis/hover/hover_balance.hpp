// What the rotors of a flight were commanded to balance in hover, on average.
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::diagnosis {

// Mean force and moments that the rotors were commanded to give in hover.
struct HoverBalance {
  Eigen::Vector4d wrench = Eigen::Vector4d::Zero();  // N along body z; N m about body x, y, z from the centre of mass
  Eigen::Vector4d deviation = Eigen::Vector4d::Zero();  // standard errors of these means within the flight
  std::vector<double> thrust_N;                         // mean of each rotor, as its command says
  std::vector<bool> limited;  // that thrust is more than the battery gave, or often the most there is
  double hover_s = 0.0;
};

inline constexpr double least_hover_s = 2.5;
// Over half seconds of slow flight, take-off and landing left out. Nothing when there is less than least_hover_s of them,
// or when the log has neither position nor velocity.
std::optional<HoverBalance> hover_balance(const FlightData& flight, const VehicleModel& vehicle);

// One rotor's part of that wrench per newton of its thrust; the index counts from 0.
Eigen::Vector4d wrench_per_newton(const VehicleModel& vehicle, int rotor_index);

}  // namespace gustlab::diagnosis
