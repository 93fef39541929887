// Streams that were recorded on clocks of their own: does the time between them stay the same along a flight?
#pragma once

#include <optional>
#include <vector>

#include "diagnosis/recording/flight_data.hpp"
#include "diagnosis/result/findings.hpp"

namespace gustlab::diagnosis {

// How much later one stream is than another along a flight: steps and slow wander, known in the middle of each stretch.
struct ClockTrack {
  std::vector<double> time_s, latency_s;
  double at(double time_s) const;
  double least_s() const, most_s() const;
};

// Of the gyro behind the attitude's rate, when the time between them changes within the flight; nothing when it does not, or when
// slow angular motion shows none. `pose`: the flight read without its gyro; rate_B_radps: gyro per sample, NaN where it has none.
std::optional<ClockTrack> gyro_track(const FlightData& pose, const std::vector<Vector3>& rate_B_radps);

// Of the vehicle's angular motion behind the (nominal) torque of its rotors, likewise.
std::optional<ClockTrack> command_track(const FlightData& flight, const VehicleModel& vehicle);

// All that was recorded on board (gyro, accelerometer, inputs, rotor speeds, battery) as much earlier as the track says.
FlightLog laid_on_pose_clock(FlightLog log, const ClockTrack& track);

// Whether in one of the flights the commands cannot be laid beside the motion: what the logs showed by themselves (`of_logs`) has clocks
// that are apart, and the time between rotors and angular motion changes along the flight, too (one more `delay` among `findings`).
bool clocks_apart(const std::vector<FlightData>& flights, const VehicleModel& vehicle,
                  const std::vector<LogFinding>& of_logs, std::vector<LogFinding>& findings);

}  // namespace gustlab::diagnosis
