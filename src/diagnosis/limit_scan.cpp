#include "diagnosis/limit_scan.hpp"

#include <algorithm>
#include <cmath>

namespace gustlab::diagnosis {

LimitScan scan_limit(const Session& session) {
  LimitScan best;
  const VehicleModel& vehicle = session.vehicle();
  // commanded speeds above hover, highest first
  std::vector<double> speeds;
  for (const FlightData& flight : session.flights()) {
    if (!flight.measured_speed.empty()) return best;
    for (const Sample& sample : flight.samples) {
      const RotorArray mean = flight.commands.mean(sample.time_s, sample.time_s + flight.sample_s);
      for (int i = 0; i < vehicle.rotor_count; ++i)
        speeds.push_back(std::min(mean[static_cast<std::size_t>(i)], vehicle.max_speed_radps));
    }
  }
  std::sort(speeds.rbegin(), speeds.rend());
  const double hover = vehicle.hover_speed_radps();
  for (const double share : {0.0005, 0.001, 0.002, 0.004, 0.007, 0.011, 0.017, 0.026, 0.04, 0.06, 0.09, 0.13}) {
    const double limit = speeds[static_cast<std::size_t>(share * static_cast<double>(speeds.size()))];
    if (limit < 1.02 * hover || limit > 0.999 * vehicle.max_speed_radps) continue;
    double dp = 0.0, pp = 0.0, samples = 0.0;
    for (std::size_t f = 0; f < session.flights().size(); ++f) {
      const FlightData& flight = session.flights()[f];
      const auto push = limit_change(flight, static_cast<int>(f), session.catalogue(), session.value(), limit);
      for (std::size_t k = 0; k < push.size(); ++k) {
        if (push[k].isZero(0.0)) continue;
        samples += 1.0;
        for (int j = 2; j < 6; ++j) {
          const double weight = std::pow(session.noise.rms(static_cast<std::size_t>(disturbance_group[static_cast<std::size_t>(j)])), -2);
          dp += weight * push[k][j] * session.smoothed[f].disturbance[k][j];
          pp += weight * push[k][j] * push[k][j];
        }
      }
    }
    if (samples < 10.0 || pp <= 0.0) continue;
    const double strength = dp / pp;
    if (strength > 0.2 && dp * strength > best.gain) best = {limit, dp * strength};
  }
  return best;
}

}  // namespace gustlab::diagnosis
