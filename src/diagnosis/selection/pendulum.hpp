// A load on a cable, as the force history that a vehicle's own motion gives it.
#pragma once

#include <vector>

#include "diagnosis/selection/swing_fit.hpp"

namespace gustlab::diagnosis {

struct PendulumScan {
  Swing swing;
  double share = 0.0;  // of the horizontal disturbance that the load explains, beyond drag
  double mass_kg = 0.0;
  std::vector<SwingStart> starts;  // per flight, where the swing was fitted at any angle
};

// Scans cable lengths and dampings on the smoothed disturbance of a session (0.1 s means): driven by the vehicle's
// acceleration, with a free start of the swing in every flight. A lateral point-load pendulum, Pounds, Bersak & Dollar, ICRA 2011.
PendulumScan scan_pendulum(const Session& session);

// Force in W on the vehicle per kg of a load that swings like this one, in another flight: the swing's start is the one that
// fits the smoothed disturbance best.
std::vector<Vector3> pendulum_force(const FlightData& flight, const Smoothed& smoothed, double vehicle_mass_kg,
                                    const Swing& swing, double load_kg);

}  // namespace gustlab::diagnosis
