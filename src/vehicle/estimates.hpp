// Rules of thumb for what nobody measured, each with its spread (one standard deviation, relative) and its source.
#pragma once

#include "gustlab/types.hpp"

namespace gustlab {

inline constexpr double standard_gravity_mps2 = 9.80665;  // of the units gf and kgf (CGPM 1901)

// Small propellers at rest have C_T = 0.11 ± 0.025 and C_P = 0.048 ± 0.015 (Brandt, Selig, Propeller Performance Data at Low
// Reynolds Numbers, AIAA 2011-1255). Thrust = C_T ρ D⁴ (Ω / 2π)², torque / thrust = C_P D / (2π C_T).
inline constexpr double propeller_ct = 0.11, propeller_ct_spread = 0.25;
inline constexpr double torque_ratio_per_diameter = 0.07, torque_ratio_spread = 0.35;
inline double estimated_thrust_coefficient_Ns2(double diameter_m) {
  return propeller_ct * air_density_kgpm3 * diameter_m * diameter_m * diameter_m * diameter_m / (4.0 * pi * pi);
}

// Propellers of neighbours nearly touch: diameter over the distance between neighbouring hubs. Crazyflie 2.1 0.71, Iris 0.77,
// Hummingbird and Pelican (RotorS) 0.85, a 5-inch racer (Bauersfeld et al., RSS 2021) 0.85.
inline constexpr double diameter_per_hub_distance = 0.8, diameter_spread = 0.15;

// Moments of inertia in units of mass times the square of the arm, roll and pitch, and yaw: Crazyflie 2.1 (Förster, ETH 2015) 0.29,
// 0.51; Iris (ArduPilot's Gazebo model) 0.15, 0.20; Hummingbird 0.34, 0.58 and Pelican 0.23, 0.45 (RotorS, Furrer et al. 2016);
// 5-inch racer (Bauersfeld et al., RSS 2021) 0.20, 0.37.
inline constexpr double tilt_inertia_factor = 0.24, yaw_inertia_factor = 0.42, inertia_spread = 0.35;

// f of thrust ~ f u² + (1 − f) u of motor controllers that are given no curve: ArduPilot's default MOT_THST_EXPO; its
// documentation recommends 0.55 for small propellers to 0.75 for large ones. An absolute spread.
inline constexpr double usual_throttle_curve = 0.65, throttle_curve_spread = 0.15;

}  // namespace gustlab
