#include <fmt/format.h>

#include <cmath>

#include "config/toml.hpp"
#include "gustlab/errors.hpp"
#include "vehicle/new_vehicle.hpp"

namespace gustlab {

namespace {

using Place = Layout::Place;

constexpr Place quad_x[] = {{45, true}, {-135, true}, {-45, false}, {135, false}};
constexpr Place quad_plus[] = {{90, true}, {-90, true}, {0, false}, {180, false}};
constexpr Place quad_betaflight[] = {{135, false}, {45, true}, {-135, true}, {-45, false}};
constexpr Place quad_crazyflie[] = {{45, true}, {135, false}, {-135, true}, {-45, false}};
constexpr Place hexa_x[] = {{90, false}, {-90, true}, {-30, false}, {150, true}, {30, true}, {-150, false}};
constexpr Place hexa_plus[] = {{0, false}, {180, true}, {-120, false}, {60, true}, {-60, true}, {120, false}};
constexpr Place octo_x[] = {{22.5, false}, {-157.5, false}, {67.5, true},   {157.5, true},
                            {-22.5, true}, {-112.5, true},  {-67.5, false}, {112.5, false}};
constexpr Place octo_plus[] = {{0, false},  {180, false}, {45, true},   {135, true},
                               {-45, true}, {-135, true}, {-90, false}, {90, false}};

constexpr std::string_view autopilots = "motor numbers and directions of PX4 and ArduPilot";
constexpr Layout known[] = {
    {"x", "four arms, two forward", autopilots, quad_x},
    {"+", "four arms, one forward", autopilots, quad_plus},
    {"x-betaflight", "four arms, two forward", "motor numbers and directions of Betaflight", quad_betaflight},
    {"x-crazyflie", "four arms, two forward", "motor numbers and directions of the Crazyflie", quad_crazyflie},
    {"hexa", "six arms, two forward", autopilots, hexa_x},
    {"hexa+", "six arms, one forward", autopilots, hexa_plus},
    {"octo", "eight arms, two forward", autopilots, octo_x},
    {"octo+", "eight arms, one forward", autopilots, octo_plus},
};

}  // namespace

std::span<const Layout> layouts() { return known; }

const Layout& find_layout(std::string_view name) {
  std::vector<std::string> names;
  for (const Layout& layout : known) {
    if (layout.name == name) return layout;
    names.emplace_back(layout.name);
  }
  throw ConfigError(worded(fmt::format("--layout: there is no layout \"{}\"", name),
                           fmt::format("known: {}", fmt::join(names, ", ")), config::suggest(name, names)));
}

std::vector<Hub> hubs_on_circle(const Layout& layout, double arm_m) {
  std::vector<Hub> hubs;
  for (const Place& place : layout.places) {
    const double angle = place.degrees * pi / 180.0;
    hubs.push_back({{arm_m * std::cos(angle), -arm_m * std::sin(angle), 0.0}, place.counter_clockwise});
  }
  return hubs;
}

}  // namespace gustlab
