// Flights ready for the filter whose motion and commands are formulas.
#pragma once

#include <functional>

#include "diagnosis/recording/flight_data.hpp"

namespace gustlab::test {

using MotionAt = std::function<diagnosis::Motion(double)>;
using SpeedsAt = std::function<RotorArray(double)>;

inline diagnosis::CommandRecord record_of(const SpeedsAt& speeds, double duration_s, double step_s, bool linear) {
  std::vector<double> time_s;
  std::vector<RotorArray> rows;
  for (int k = 0; k * step_s <= duration_s + 0.5 * step_s; ++k)
    time_s.push_back(k * step_s), rows.push_back(speeds(time_s.back()));
  return {std::move(time_s), std::move(rows), linear};
}

// Every channel is measured, without noise.
inline diagnosis::FlightData flight_of(const VehicleModel& vehicle, double duration_s, double sample_s,
                                       const MotionAt& motion, const SpeedsAt& speeds) {
  diagnosis::FlightData flight;
  flight.file = flight.label = "formula.csv";
  flight.vehicle = vehicle;
  flight.sample_s = sample_s;
  flight.as_recorded = true;
  flight.commands = record_of(speeds, duration_s, sample_s, false);
  for (int k = 0; k * sample_s <= duration_s + 0.5 * sample_s; ++k) {
    const diagnosis::Motion at = motion(k * sample_s);
    diagnosis::Sample sample;
    sample.time_s = k * sample_s;
    sample.channels = diagnosis::has_position | diagnosis::has_velocity | diagnosis::has_attitude | diagnosis::has_rate;
    sample.starts_segment = k == 0;
    sample.position_W_m = at.position_W_m;
    sample.velocity_W_mps = at.velocity_W_mps;
    sample.attitude_WB = at.attitude_WB;
    sample.body_rate_B_radps = at.body_rate_B_radps;
    flight.samples.push_back(sample);
    flight.motion.push_back(at);
  }
  return flight;
}

inline RotorArray all_at(double speed_radps) {
  RotorArray speeds;
  speeds.fill(speed_radps);
  return speeds;
}

}  // namespace gustlab::test
