// A load on a cable as it swings, at any angle, below a vehicle that moves as it was recorded.
#pragma once

#include <limits>
#include <vector>

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

// What swings alike in all flights, and what is a flight's own.
struct SwingingLoad {
  Swing swing;
  double mass_kg = 0.0;
  double drag_kgps = 0.0;  // of the vehicle, beside the load
};
struct SwingStart {
  Eigen::Vector2d cable_W = Eigen::Vector2d::Zero(),
                  rate_W_radps = Eigen::Vector2d::Zero();  // horizontal parts of the cable's direction and its rate
  Eigen::Vector2d trim_N = Eigen::Vector2d::Zero();        // constant horizontal force
};

// Samples of a flight whose means are compared: 0.1 s.
std::size_t bin_of(const FlightData& flight);

// Force in W on the vehicle per kg of load, per sample: tension of a massless cable, slack when it would push, and the
// friction of its hook. Pounds, Bersak & Dollar, ICRA 2011; Sreenath, Lee & Kumar, CDC 2013, eq. (1)-(4), with the vehicle's
// acceleration given. Of the first `samples` of the flight.
std::vector<Vector3> swinging_force(const FlightData& flight, const Swing& swing, const SwingStart& start,
                                    std::size_t samples = std::numeric_limits<std::size_t>::max());

// Gauss–Newton on the horizontal disturbance (0.1 s means), from the given values: of the starts, and of the load too when
// `load_free`. Returns the squares that are left, N²; not finite when the given swing is out of all bounds.
double fit_swing(const std::vector<const FlightData*>& flights, const std::vector<const Smoothed*>& smoothed,
                 double vehicle_mass_kg, SwingingLoad& load, std::vector<SwingStart>& starts, bool load_free);

}  // namespace gustlab::diagnosis
