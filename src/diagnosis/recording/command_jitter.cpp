#include "diagnosis/recording/command_jitter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

using OfRotor = std::function<double(const Rotor&, const VehicleModel&)>;

// Commands or measured speeds.
using Rotors = CommandRecord FlightData::*;

// Sum over rotors of squared speeds, each times its weight, at every new row of them: other columns may be logged faster.
std::vector<double> sums_at_rows(const FlightData& flight, Rotors of, const OfRotor& weight) {
  const CommandRecord& record = flight.*of;
  const auto& rows = record.speed_radps();
  const auto rotors = static_cast<std::size_t>(flight.vehicle.rotor_count);
  std::vector<double> sums;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double time_s = record.time_s()[k];
    const bool flown = time_s >= flight.start_s && time_s <= flight.start_s + flight.duration_s();
    if (!flown || (k > 0 && rows[k] == rows[k - 1])) continue;
    double sum = 0.0;
    for (std::size_t i = 0; i < rotors; ++i)
      sum += weight(flight.vehicle.rotors[i], flight.vehicle) * std::pow(rows[k][i], 2);
    sums.push_back(sum);
  }
  return sums;
}

// Of a flight's commands or speeds: sums over them of the square of what is faster than half a hertz, and of its white part.
struct Squares {
  double white = 0.0, all = 0.0;
};

Squares squares_of(const FlightData& flight, Rotors of, const OfRotor& weight) {
  const std::vector<double> total = sums_at_rows(flight, of, weight);
  if (total.size() < 200) return {};
  constexpr double slow_s = 2.0;
  const auto half = static_cast<std::size_t>(0.5 * slow_s * static_cast<double>(total.size()) / flight.duration_s());
  // what is slower than the window's mean is trim
  Squares squares;
  double running = 0.0;
  for (std::size_t k = 0; k < 2 * half + 1 && k < total.size(); ++k) running += total[k];
  std::size_t count = 0;
  for (std::size_t k = half; k + half + 1 < total.size(); ++k, ++count) {
    squares.all += std::pow(total[k] - running / static_cast<double>(2 * half + 1), 2);
    running += total[k + half + 1] - total[k - half];
  }
  squares.white = std::pow(third_difference_noise(total), 2) * static_cast<double>(count);
  return squares;
}

double white_share(const std::vector<const FlightData*>& flights, Rotors of, const OfRotor& weight) {
  Squares sum;
  for (const FlightData* flight : flights) {
    if ((flight->*of).empty()) continue;
    const Squares own = squares_of(*flight, of, weight);
    sum.white += own.white, sum.all += own.all;
  }
  return sum.all > 0.0 ? std::min(1.0, sum.white / sum.all) : 0.0;
}

// Measured speeds of rotors that turn out slower than the loop are smooth where its commands jitter. Rotors that are late by their file are left
// out: what torques are named from their speeds was wrong as often as right (docs/decisions/25).
double white_share(const std::vector<const FlightData*>& flights, const OfRotor& weight) {
  const double commanded = white_share(flights, &FlightData::commands, weight);
  if (std::ranges::any_of(flights, [](const FlightData* flight) {
        return flight->measured_speed.empty() || rotors_are_late(flight->vehicle);
      }))
    return commanded;
  return std::min(commanded, white_share(flights, &FlightData::measured_speed, weight));
}

}  // namespace

double command_jitter_share(std::vector<const FlightData*> flights) {
  std::erase_if(flights, [](const FlightData* flight) { return flight->collective_only; });
  double largest = 0.0;
  for (int axis = 0; axis < 2; ++axis)
    largest = std::max(largest, white_share(flights, [axis](const Rotor& rotor, const VehicleModel& vehicle) {
                         return (rotor.position_B_m - vehicle.center_of_mass_B_m).cross(rotor.axis_B)[axis];
                       }));
  return largest;
}

double thrust_jitter_share(const std::vector<const FlightData*>& flights) {
  return white_share(flights, [](const Rotor& rotor, const VehicleModel&) { return rotor.thrust_coefficient_Ns2; });
}

bool only_mean_thrust_known(const std::vector<FlightData>& flights) {
  std::vector<const FlightData*> sampled;
  for (const FlightData& flight : flights)
    if (flight.each_rotor && !flight.hold_known) sampled.push_back(flight.each_rotor.get());
  return thrust_jitter_share(sampled) >= decisions::most_command_jitter;
}

}  // namespace gustlab::diagnosis
