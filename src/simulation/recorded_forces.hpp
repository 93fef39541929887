// The forces that the known model sees along a recording: rotor speeds from the log, and what follows from them.
#pragma once

#include <vector>

#include "gustlab/flight_log.hpp"
#include "plant/force_model.hpp"

namespace gustlab {

// What counts as known: the vehicle with its own [[effect]] tables, or its thrust alone.
enum class Known { vehicle, thrust };

class RecordedForces {
 public:
  // Measured rotor speeds where the log has them, otherwise its inputs through the vehicle's maps and actuation, held
  // from row to row where the log says zoh, and straight between rows where it does not. Throws DataError when the log has neither, or for the wrong number of rotors.
  RecordedForces(const FlightLog& log, const VehicleModel& vehicle, Known known);

  struct Force {
    Vector3 force_B_N = Vector3::Zero();  // all but weight
    double thrust_N = 0.0;                // along body z
  };
  // At a row's rotor speeds and a state; NaN where the log does not yet say the speeds.
  Force at(std::size_t row, const VehicleState& state) const;

  const VehicleModel& vehicle() const { return forces_.vehicle(); }  // with body effects

 private:
  ForceModel forces_;
  std::vector<double> memory_;           // of the effects, at rest
  std::vector<RotorArray> speed_radps_;  // per row
  std::vector<double> voltage_V_;        // per row; 0: not measured
};

}  // namespace gustlab
