// what the pilot asks for
#pragma once

#include <functional>
#include <vector>

#include "truth.hpp"

namespace reality {

constexpr double kPreroll_s = 4.0;  // flown before the recording starts
constexpr double kFlight_s = 25.0;

/// Reference of one flight, defined for -kPreroll_s <= t <= kFlight_s.
struct Path {
  std::function<Vec3(double)> position_W_m;
  std::function<double(double)> yaw_rad;
  std::function<Vec3(double)> shake_radps2;  // angular acceleration added to the autopilot's torques
  std::function<double(double)> surge_mps2;  // vertical acceleration added to the autopilot's thrust
};

enum class Figure { circle, staircase, waypoints, holdout };

/// Draws one flight of the wanted figure. Low and near passes come only where the sidecar knows the surroundings;
/// `slow` lowers the speeds of a vehicle that must be flown gently.
Path draw_path(Figure figure, const Nominal& nominal, const Surroundings& around, double gentleness, Rng& rng);

}  // namespace reality
