// Writing a vehicle from the few numbers that its owner knows; every number says where it comes from.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab {

// A number and where it comes from, for the comment beside it.
struct Sourced {
  double value = 0.0;
  std::string source;
};

// Where a hub is, x forward, y left, z up, m, and which way its propeller turns seen from above.
struct Hub {
  Vector3 position_B_m = Vector3::Zero();
  bool counter_clockwise = true;
};

// Hubs on a circle: degrees clockwise from the nose, in the motors' order.
struct Layout {
  std::string_view name, says, source;
  struct Place {
    double degrees;
    bool counter_clockwise;
  };
  std::span<const Place> places;
};
std::span<const Layout> layouts();
// Throws ConfigError with a suggestion.
const Layout& find_layout(std::string_view name);
std::vector<Hub> hubs_on_circle(const Layout& layout, double arm_m);

struct NewVehicle {
  std::string name;
  Sourced mass_kg;
  std::vector<Hub> hubs;
  std::string hubs_source;
  std::optional<Sourced> propeller_diameter_m, hover, thrust_to_weight, throttle_curve, torque_ratio_m;
  std::optional<std::array<Sourced, 3>> inertia_kgm2;  // about x, y, z; absent: estimated from mass and arm
};

struct VehicleFiles {
  std::string vehicle_toml, mjcf;
  std::vector<std::string> warnings;  // numbers that are possible and unusual
};
// vehicle.toml and NAME.xml. Needs hover or thrust_to_weight. Throws ConfigError when the numbers contradict each other.
VehicleFiles new_vehicle_files(const NewVehicle& wanted);

}  // namespace gustlab
