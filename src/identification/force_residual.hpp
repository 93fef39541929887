// The target of the identification: the force that the known physics leaves over on a recorded flight.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "control/feature_terms.hpp"
#include "gustlab/flight_log.hpp"
#include "gustlab/vehicle.hpp"
#include "identification/differentiation.hpp"

namespace gustlab {

// What the known model says of one row: force without weight, and the total thrust along body z; NaN when it cannot
// say.
struct KnownForce {
  Vector3 force_B_N = Vector3::Zero();
  double thrust_N = 0.0;
};
using KnownModel = std::function<KnownForce(std::size_t row, const VehicleState& state)>;

// Where the acceleration comes from: the derivative of the velocity, as in the paper, or the accelerometer.
enum class AccelerationSource { velocity, accelerometer };

// Samples of one flight, or of an unbroken part of one.
struct ResidualSamples {
  std::vector<double> time_s;
  std::vector<FeatureInput> inputs;
  Eigen::MatrixXd force_W_N;  // samples × 3
};

// f = m a + m g e₃ − R F_known, N in W (arXiv 2603.08863, equation 2 and "f_dist"); a of the centre of mass. Velocity
// is the derivative of position where the log has none. State, thrust and known force are smoothed alike. Rows that
// lack a needed value are left out; the flight is cut at gaps, and every part trimmed at its edges. Throws DataError
// when the log lacks a needed column, or nothing is left.
std::vector<ResidualSamples> force_residual(const FlightLog& log, const VehicleModel& vehicle, const KnownModel& known,
                                            const Differentiation& differentiation, AccelerationSource source);

}  // namespace gustlab
