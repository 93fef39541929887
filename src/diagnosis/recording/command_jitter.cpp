#include "diagnosis/recording/command_jitter.hpp"

#include <algorithm>
#include <cmath>

namespace gustlab::diagnosis {

double command_jitter_share(const FlightData& flight) {
  if (flight.collective_only || flight.commands.empty() || flight.samples.size() < 200) return 0.0;
  const VehicleModel& vehicle = flight.vehicle;
  constexpr double slow_s = 2.0, instant_s = 1e-5;
  const auto half = static_cast<std::size_t>(0.5 * slow_s / flight.sample_s);
  double largest = 0.0;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> torque;
    for (const Sample& sample : flight.samples) {
      const RotorArray speed = flight.commands.mean(sample.time_s, sample.time_s + instant_s);
      double sum = 0.0;
      for (int i = 0; i < vehicle.rotor_count; ++i) {
        const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(i)];
        sum += (rotor.position_B_m - vehicle.center_of_mass_B_m).cross(rotor.axis_B)[axis] *
               std::pow(speed[static_cast<std::size_t>(i)], 2);
      }
      torque.push_back(sum);
    }
    // what is slower than the window's mean is trim
    double variance = 0.0, running = 0.0;
    for (std::size_t k = 0; k < 2 * half + 1 && k < torque.size(); ++k) running += torque[k];
    std::size_t count = 0;
    for (std::size_t k = half; k + half + 1 < torque.size(); ++k, ++count) {
      variance += std::pow(torque[k] - running / static_cast<double>(2 * half + 1), 2);
      running += torque[k + half + 1] - torque[k - half];
    }
    if (count == 0 || variance == 0.0) continue;
    largest = std::max(largest, std::pow(third_difference_noise(torque), 2) * static_cast<double>(count) / variance);
  }
  return std::min(1.0, largest);
}

}  // namespace gustlab::diagnosis
